// Wrong command lines, said in one sentence.
#include "shared.h"

#include "config.h"

#include <algorithm>

namespace vdbcloud::app {

namespace {

std::string expected(const CLI::Option* option)
{
    if (option && option->get_items_expected_max() == 0) return "expected true or false";
    return "not a value this can take";
}

bool looks_like_option(const std::string& word)
{
    return word.size() > 1 && word[0] == '-' && std::string("0123456789.").find(word[1]) == std::string::npos;
}

/// "-o, -q or -v"
std::string short_names(const CLI::App& app)
{
    std::vector<std::string> names;
    for (const CLI::Option* option : app.get_options())
        for (const std::string& name : option->get_snames()) names.push_back("-" + name);
    std::string all;
    for (size_t k = 0; k < names.size(); ++k) all += (k == 0 ? "" : k + 1 < names.size() ? ", " : " or ") + names[k];
    return all;
}

/// About the words that no option and no argument takes. CLI11 gives them in an order of its own, and where an unknown
/// option has a value, that value may be among them, or may have become an argument: the option is what is wrong.
std::string unexpected(const CLI::App& app)
{
    const std::vector<std::string> words = app.remaining();
    const auto option = std::find_if(words.begin(), words.end(), looks_like_option);
    if (option == words.end()) return "unexpected argument '" + words.back() + "'";
    const std::string word = option->substr(0, option->find('='));
    const std::string unknown = "unknown option '" + word + "'";
    if (word.size() == 2 && word[1] != '-') return unknown + "; expected " + short_names(app);
    return unknown + suggestion(app, word.substr(word[1] == '-' ? 2 : 1), "--");
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
    if (dynamic_cast<const CLI::ExtrasError*>(&error)) return unexpected(*this);
    if (error.get_name() == "RequiredError") {
        const std::string name = what.substr(0, what.find(' '));
        return name[0] == '-' ? "the option " + name + " is required"
                              : what + ": name a file, or - to read from a pipe";
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
