#include "option.h"

#include "shared.h"

#include "vdbcloud/core/error.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace vdbcloud::app {

CLI::Option* Option::cli() const
{
    if (!option_) throw std::logic_error("internal error: a handle of an option that was not declared");
    return option_;
}

Option Option::check(const CLI::Validator& validator) const { return cli()->check(validator), *this; }
Option Option::group(const std::string& name) const { return cli()->group(name), *this; }
Option Option::required() const { return cli()->required(), *this; }
Option Option::configurable(bool is) const { return cli()->configurable(is), *this; }
Option Option::default_str(const std::string& text) const { return cli()->default_str(text), *this; }
Option Option::type_name(const std::string& name) const { return cli()->type_name(name), *this; }
Option Option::expected(int count) const { return cli()->expected(count), *this; }
Option Option::allow_extra_args() const { return cli()->allow_extra_args(), *this; }

Option Option::reads_files() const { return app_->shared_->files.push_back({*this, std::nullopt, false}), *this; }
Option Option::writes_file(FileKind kind) const { return app_->shared_->files.push_back({*this, kind, false}), *this; }
Option Option::rewrites_file(FileKind kind) const { return app_->shared_->files.push_back({*this, kind, true}), *this; }
Option Option::writes_frames(FileKind kind) const
{
    return app_->shared_->files.push_back({*this, kind, false, true}), *this;
}

namespace {

/// The name without dashes, and without that of what it belongs to.
std::string key_of(const std::string& option, const std::string& owner)
{
    const std::string name = option.substr(option.find_first_not_of('-')), prefix = owner + "-";
    return name.rfind(prefix, 0) == 0 ? name.substr(prefix.size()) : name;
}

}  // namespace

Option Option::scene(const std::string& section, const std::string& key) const
{
    const auto is_it = [&](const SceneSection& s) { return section == s.name; };
    if (std::none_of(scene_sections().begin(), scene_sections().end(), is_it))
        throw std::logic_error(name() + ": scene files have no section " + section);
    app_->shared_->scene_keys.push_back({*this, section, key.empty() ? key_of(name(), section) : key, "", ""});
    return *this;
}

Option Option::scene_light(const Option& light, const std::string& otherwise) const
{
    const std::string kind = key_of(light.name(), "");
    app_->shared_->scene_keys.push_back({*this, "lights", key_of(name(), kind), kind, otherwise});
    return *this;
}

bool Option::by_scene() const { return app_->of_scene(cli()); }

std::string Option::name() const { return cli()->get_name(); }

std::string Option::text() const
{
    std::string all = name();
    for (const Setting& setting : settings(*app_))
        if (setting.option == option_)
            for (const std::string& word : setting.words) all += " " + word;
    return all;
}

bool Option::given() const
{
    if (cli()->count() == 0) return false;
    const bool flag = option_->get_items_expected_max() == 0;
    if (app_->on_command_line(option_) || (by_scene() && !flag)) return true;
    for (const Setting& setting : settings(*app_))
        if (setting.option == option_) return setting.words != default_words(setting);
    return true;
}

void Option::refuse(const std::string& why) const { throw UsageError(app_->place(option_) + name() + why); }

void Option::rule(const std::function<bool()>& holds, const std::string& why) const
{
    const auto refused = [option = *this, holds, why] {
        if (option.given() && !holds()) option.refuse(why);
    };
    app_->shared_->rules.push_back({cli(), holds, refused});
}

namespace {

std::string without(const std::string& wanted, const std::string& name)
{
    return " has no effect without " + wanted + ": add " + wanted + ", or leave out " + name;
}

}  // namespace

Option Option::needs(const Option& other) const
{
    return only_with([other] { return other.given(); }, other.name());
}

Option Option::only_with(const std::function<bool()>& met, const std::string& wanted) const
{
    return rule(met, without(wanted, name())), *this;
}

Option Option::not_with(std::function<bool()> met, const std::string& unwanted) const
{
    const auto unmet = [met = std::move(met)] { return !met(); };
    return rule(unmet, " has no effect with " + unwanted + ": leave out one of them"), *this;
}

Option Option::no_rung_with(std::function<bool()> met) const
{
    app_->shared_->rung_rules.push_back({cli(), [met = std::move(met)] { return !met(); }, {}});
    return *this;
}

bool Option::by_rung() const
{
    const std::vector<Option>& set = app_->shared_->rung_set;
    return std::any_of(set.begin(), set.end(), [&](const Option& other) { return other.cli() == cli(); });
}

void Option::check_effect(bool met, const std::string& wanted) const
{
    if (!given() || by_scene()) return;
    App::Shared& s = *app_->shared_;
    if (!s.frame) {
        if (!met) refuse(without(wanted, name()));
        return;
    }
    FrameNeed& need = s.frame_needs[name() + " " + wanted];
    need.met = need.met || met;
    if (met || !need.refusal.empty()) return;
    need.refusal = app_->place(option_) + name() + without(wanted, name());
    need.remark = name() + " has no effect on this frame: it needs " + wanted;
}

}  // namespace vdbcloud::app
