#include "solid_options.h"

#include "inputs.h"
#include "nearest.h"
#include "sky_options.h"

#include "vdbcloud/core/error.h"
#include "vdbcloud/core/vdb.h"
#include "vdbcloud/grid/select.h"

#include <algorithm>

namespace vdbcloud::app {

namespace {

std::string trimmed(const std::string& text)
{
    const auto first = text.find_first_not_of(" \t"), last = text.find_last_not_of(" \t");
    return first == std::string::npos ? "" : text.substr(first, last - first + 1);
}

/// One --solid, word by word. Each word has to be asked for once, else it has no effect and is refused.
class Words {
public:
    explicit Words(const std::string& text) : text_(text)
    {
        for (const std::string& part : split(text, ';')) {
            const std::string word = trimmed(part);
            if (!word.empty()) left_.push_back(word);
        }
        if (left_.empty()) refuse("it is empty");
        shape = left_.front();
        left_.erase(left_.begin());
    }
    std::string shape;

    bool has(const std::string& word)
    {
        const auto at = std::find(left_.begin(), left_.end(), word);
        if (at == left_.end()) return false;
        left_.erase(at);
        return true;
    }
    /// The text behind KEY=; empty if the key is not there.
    std::string value(const std::string& key)
    {
        for (size_t n = 0; n < left_.size(); ++n)
            if (const auto sign = left_[n].find('=');
                sign != std::string::npos && trimmed(left_[n].substr(0, sign)) == key) {
                const std::string out = trimmed(left_[n].substr(sign + 1));
                left_.erase(left_.begin() + std::ptrdiff_t(n));
                if (out.empty()) refuse("'" + key + "=' has no value");
                return out;
            }
        return "";
    }
    Vec3d place(const std::string& key, const std::optional<Vec3d>& otherwise)
    {
        const std::string text = value(key);
        if (text.empty() && otherwise) return *otherwise;
        const auto c = numbers(text);
        if (!c || c->size() != 3) refuse("'" + key + "=" + text + "': expected x,y,z");
        return {(*c)[0], (*c)[1], (*c)[2]};
    }
    double size(const std::string& key, const std::optional<double>& otherwise)
    {
        const std::string text = value(key);
        if (text.empty() && otherwise) return *otherwise;
        const auto x = number(text);
        if (!x) refuse("'" + key + "=" + text + "': expected a number");
        return *x;
    }
    Vec3d colour(const std::string& key, const Vec3d& otherwise)
    {
        const std::string text = value(key);
        return text.empty() ? otherwise : colour_asked(context() + key, text, "one number or r,g,b");
    }
    /// Throws for words that nothing has asked for. `known`: all that there are, for this shape.
    void finish(const std::vector<std::string>& known) const
    {
        if (left_.empty()) return;
        std::string list;
        for (const std::string& word : known) list += (list.empty() ? "" : ", ") + word;
        refuse("'" + left_.front() + "': expected each of " + list + " once at most");
    }
    [[noreturn]] void refuse(const std::string& why) const { throw UsageError(context() + why); }

private:
    std::string context() const { return "--solid '" + printable(text_) + "': "; }
    std::string text_;
    std::vector<std::string> left_;
};

Material material_of(Words& words, std::vector<std::string>& known, const Material& otherwise)
{
    Material m = otherwise;
    int finishes = 0;
    for (const Finish finish : {Finish::Diffuse, Finish::Mirror, Finish::Glossy})
        if (words.has(name(finish))) {
            m.finish = finish;
            ++finishes;
        }
    if (finishes > 1) words.refuse("expected one of diffuse, mirror and glossy");
    m.colour = words.colour("colour", m.colour);
    known.insert(known.end(), {"diffuse", "mirror", "glossy", "colour=r,g,b", "checker=r,g,b"});
    if (const Vec3d second = words.colour("checker", Vec3d(-1.0)); second[0] >= 0) {
        m.checker = second;
        m.checker_edge = words.size("edge", m.checker_edge);
        known.push_back("edge=LENGTH");
    }
    if (m.finish == Finish::Glossy) {
        m.roughness = words.size("roughness", m.roughness);
        known.push_back("roughness=0..1");
    }
    return m;
}

std::vector<Solid> solids_of_file(App& app, const std::string& path)
{
    const GridFile file = app.read(path);
    return of_file(file.path, [&] {
        std::vector<Solid> solids = solids_of(file);
        if (solids.empty())
            for (const GridBasePtr& grid : file.grids)
                if (grid->getGridClass() == openvdb::GRID_LEVEL_SET && grid->isType<FloatGrid>())
                    solids.push_back(make_level_set(openvdb::gridPtrCast<FloatGrid>(grid)));
        if (solids.empty()) throw InputError("expected a level set of floats, and the file has " + grid_list(file));
        for (const Solid& solid : solids) check(solid);
        return solids;
    });
}

std::vector<Solid> parsed(App& app, const std::string& text, const Vec3d& up)
{
    Words words(text);
    std::vector<std::string> known;
    std::vector<Solid> solids;
    const auto made = [&](Solid solid) {
        solid.material = material_of(words, known, {});
        words.finish(known);
        try {
            check(solid);
        } catch (const InputError& e) {
            words.refuse(e.what());
        }
        solids.push_back(std::move(solid));
        return solids;
    };
    if (words.shape == "plane") {
        known = {"at=x,y,z", "up=x,y,z"};
        const Vec3d at = words.place("at", Vec3d(0.0)), normal = words.place("up", up);
        if (!(normal.length() > 0)) words.refuse("'up': expected a direction");
        return made(make_plane(at, normal));
    }
    if (words.shape == "sphere") {
        known = {"at=x,y,z", "radius=LENGTH"};
        const Vec3d at = words.place("at", Vec3d(0.0));
        return made(make_ball(at, words.size("radius", std::nullopt)));
    }
    if (words.shape == "box") {
        known = {"from=x,y,z", "to=x,y,z"};
        const Vec3d from = words.place("from", std::nullopt);
        return made(make_box(from, words.place("to", std::nullopt)));
    }
    const auto ends = [&](const std::string& end) {
        return words.shape.size() >= end.size() &&
               words.shape.compare(words.shape.size() - end.size(), end.size(), end) == 0;
    };
    if (!ends(".vdb")) words.refuse("'" + words.shape + "': expected plane, sphere, box, or the path of a .vdb");
    solids = solids_of_file(app, words.shape);
    for (Solid& solid : solids) {
        Words again(text);
        solid.material = material_of(again, known, solid.material);
        again.finish(known);
    }
    return solids;
}

}  // namespace

void declare_solids(App& app, SolidOptions& o, const std::string& group)
{
    o.option =
        app.add_option(
               "--solid", o.asked,
               "an opaque body beside the medium; repeat for another. A shape: 'plane; at=x,y,z; up=x,y,z' (all "
               "below a plane without end), 'sphere; at=x,y,z; radius=R', 'box; from=x,y,z; to=x,y,z', or a .vdb "
               "with level sets, such as fractalgen --mountain writes. Then its material: diffuse, mirror or "
               "'glossy; roughness=0..1', colour=r,g,b, and 'checker=r,g,b; edge=LENGTH' for a second colour. "
               "Without it the solids of the file")
            .scene("solids")
            .type_name("SOLID")
            .group(group);
}

std::vector<Solid> chosen_solids(App& app, const SolidOptions& o, const std::vector<const GridFile*>& files,
                                 const Vec3d& up)
{
    std::vector<Solid> solids;
    for (const std::string& text : o.asked)
        for (Solid& solid : parsed(app, text, up)) solids.push_back(std::move(solid));
    if (!o.asked.empty()) return solids;
    for (const GridFile* file : files)
        for (Solid& solid : of_file(file->path, [&] { return solids_of(*file); })) solids.push_back(std::move(solid));
    return solids;
}

}  // namespace vdbcloud::app
