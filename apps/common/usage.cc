// Wrong command lines, said in one sentence.
#include "shared.h"

#include "config.h"

namespace vdbcloud::app {

namespace {

std::string expected(const CLI::Option* option)
{
    if (option && option->get_items_expected_max() == 0) return "expected true or false";
    return "not a value this can take";
}

}  // namespace

std::string App::explain(const CLI::ParseError& error) const
{
    const std::string text = reworded(error);
    if (text.rfind("--", 0) != 0) return text;
    const CLI::Option* option = get_option_no_throw(text.substr(0, text.find(':')));
    return (option ? place(option) : "") + text;
}

std::string App::reworded(const CLI::ParseError& error) const
{
    const std::string what = error.what();
    if (dynamic_cast<const CLI::FileError*>(&error))
        return what.substr(0, what.rfind(" was not readable")) + ": cannot read this configuration file";
    if (dynamic_cast<const CLI::ExtrasError*>(&error)) {
        const std::string extra = what.substr(what.find(": ") + 2);
        const std::string word = extra.substr(0, extra.find_first_of("= "));
        if (word.size() < 2 || word[0] != '-') return "unexpected argument '" + extra + "'";
        return "unknown option '" + word + "'" + suggestion(*this, word.substr(word[1] == '-' ? 2 : 1), "--");
    }
    if (error.get_name() == "RequiredError") {
        const std::string name = what.substr(0, what.find(' '));
        return name[0] == '-' ? "the option " + name + " is required" : what;
    }
    const std::string unread = "Could not convert: ";
    if (what.rfind(unread, 0) == 0) {
        const size_t equals = what.find(" = ");
        const std::string name = what.substr(unread.size(), equals - unread.size());
        return name + ": '" + what.substr(equals + 3) + "': " + expected(get_option_no_throw(name));
    }
    if (error.get_name() == "ArgumentMismatch") {
        const size_t colon = what.find(": ");
        const std::string name = what.substr(0, colon);
        if (what.find("At Most") != std::string::npos) return name + ": given more often than once";
        if (what.find("missing") != std::string::npos) return name + ": expected a value";
    }
    return what;
}

std::string App::json_asked(int argc, char** argv)
{
    for (int k = 1; k < argc; ++k) {
        const std::string word = argv[k];
        if (word == "--json" && k + 1 < argc) return argv[k + 1];
        if (word.rfind("--json=", 0) == 0) return word.substr(7);
    }
    return {};
}

}  // namespace vdbcloud::app
