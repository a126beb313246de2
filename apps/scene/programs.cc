// The programs whose options are the keys of scene files. A program that is not here has keys of these alone, such as
// fractalgen those of the medium.
#include "../illuminate/options.h"
#include "../p1solve/options.h"
#include "../render/options.h"

#include "scene_file.h"

namespace vdbcloud::app {

namespace {

template<typename Options>
class Declared : public App {
public:
    explicit Declared(const char* name) : App(name, "") { declare(*this, options_); }

private:
    Options options_;
};

}  // namespace

std::vector<std::unique_ptr<App>> scene_programs()
{
    std::vector<std::unique_ptr<App>> programs;
    programs.push_back(std::make_unique<Declared<IlluminateOptions>>("illuminate"));
    programs.push_back(std::make_unique<Declared<P1solveOptions>>("p1solve"));
    programs.push_back(std::make_unique<Declared<RenderOptions>>("render"));
    return programs;
}

}  // namespace vdbcloud::app
