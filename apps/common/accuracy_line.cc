#include "accuracy_line.h"

namespace vdbcloud::app {

void tell_accuracy(App& app, const std::string& what, const Accuracy& accuracy, MetaMap& result)
{
    write_accuracy(result, accuracy);
    if (!accuracy.empty()) app.say("accuracy of " + what + ": " + text_of(accuracy));
}

}  // namespace vdbcloud::app
