#include "vdbcloud/sim/checkpoint.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/digest.h"
#include "vdbcloud/sim/effect.h"
#include "vdbcloud/sim/words.h"

#include <cmath>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <sstream>

namespace vdbcloud::sim {

namespace {

constexpr const char* magic = "VDBCLOUD CHECKPOINT 4\n";
constexpr size_t checksum_size = 32;

std::string exact(double x)
{
    char text[40];
    for (int digits = 6; digits <= 17; ++digits) {
        std::snprintf(text, sizeof text, "%.*g", digits, x);
        if (std::strtod(text, nullptr) == x) break;
    }
    return text;
}

/// Passes bytes to or from another buffer and adds them to a digest.
class Digesting : public std::streambuf {
public:
    explicit Digesting(std::streambuf* next) : next_(next) {}
    /// Of all bytes so far: `checksum_size` characters.
    std::string checksum() const { return digest_.hex(); }

protected:
    std::streamsize xsputn(const char* bytes, std::streamsize n) override
    {
        digest_.add(bytes, size_t(n));
        return next_->sputn(bytes, n);
    }
    int_type overflow(int_type c) override
    {
        const char byte = char(c);
        return xsputn(&byte, 1) == 1 ? c : traits_type::eof();
    }
    std::streamsize xsgetn(char* bytes, std::streamsize n) override
    {
        n = next_->sgetn(bytes, n);
        digest_.add(bytes, size_t(n));
        return n;
    }

private:
    std::streambuf* next_;
    Digest digest_;
};

}  // namespace

std::vector<std::pair<std::string, std::string>> describe(const Parameters& p, const Sounding& s)
{
    std::vector<std::pair<std::string, std::string>> list;
    const auto number = [&](const std::string& name, double x) { list.emplace_back(name, exact(x)); };
    const auto flag = [&](const std::string& name, bool on) { list.emplace_back(name, on ? "on" : "off"); };
    const auto numbers = [&](const std::string& name, const std::vector<double>& values) {
        std::string text;
        for (const double x : values) text += (text.empty() ? "" : ",") + exact(x);
        list.emplace_back(name, text);
    };
    const auto word = [&](const std::string& name, const char* text) { list.emplace_back(name, text); };
    const Lattice& l = p.lattice;
    Parameters in_force = p;
    if (p.q_scale_height == 0) in_force.q_scale_height = l.n[2] * l.h[2] / std::log(10.0);
    numbers("cells", {double(l.n[0]), double(l.n[1]), double(l.n[2])});
    numbers("spacing", {l.h[0], l.h[1], l.h[2]});
    word("side_x", side_words.word(l.side[0]));
    word("side_y", side_words.word(l.side[1]));
    word("precision", precision_words.word(p.precision));
    word("time_scheme", time_scheme_words.word(p.time_scheme));
    word("scalar_scheme", scalar_scheme_words.word(p.scalar_scheme));
    word("momentum_scheme", momentum_scheme_words.word(p.momentum_scheme));
    flag("maccormack", p.maccormack), flag("fix_budget", p.fix_budget);
    word("saturation", saturation_words.word(p.moist.by));
    const auto settings = [&](const std::vector<Setting>& group) {
        for (const Setting& setting : group) {
            if (setting.kind == Setting::Kind::Switch)
                flag(setting.key(), setting.on(in_force));
            else
                number(setting.key(), setting.number(in_force));
        }
    };
    settings(numeric_settings()), settings(constant_settings()), settings(noise_settings());
    for (const Effect& effect : effects()) settings(effect.settings);
    for (const Patch& f : p.floor.patches)
        numbers("patch", {f.centre[0], f.centre[1], f.radius, f.heat, f.moisture, f.dye});
    if (!p.floor.map.empty()) {
        Digest map;
        map.add(p.floor.map.data(), p.floor.map.size() * sizeof p.floor.map[0]);
        list.emplace_back("floor_map_digest", map.hex());
    }
    for (const Bubble& b : p.bubbles)
        numbers("bubble", {b.centre[0], b.centre[1], b.centre[2], b.radius, b.height, b.theta, b.water, b.dye});
    list.emplace_back("seed", std::to_string(p.noise.seed));
    list.emplace_back("sounding", s.name);
    numbers("sounding_z", s.z), numbers("sounding_theta", s.theta), numbers("sounding_water", s.water);
    numbers("sounding_u", s.u), numbers("sounding_v", s.v), number("sounding_pressure", s.pressure);
    return list;
}

std::string text_of(const Parameters& p, const Sounding& s)
{
    std::string text;
    for (const auto& [name, value] : describe(p, s)) text += name + " = " + value + "\n";
    return text;
}

void write_checkpoint(const std::string& path, const Simulation& sim, const Sounding& sounding, int frame)
{
    AtomicFile file(path);
    std::ofstream out(file.name(), std::ios::binary | std::ios::trunc);
    const std::string text = text_of(sim.parameters(), sounding);
    const uint64_t length = text.size();
    Digesting digesting(out.rdbuf());
    std::ostream stream(&digesting);
    stream << magic;
    stream.write(reinterpret_cast<const char*>(&length), 8);
    stream.write(text.data(), std::streamsize(length));
    stream.write(reinterpret_cast<const char*>(&frame), sizeof frame);
    sim.save(stream);
    out << digesting.checksum();
    out.flush();
    if (!stream || !out) throw IoError(path + ": cannot write the checkpoint (is the disk full?)");
    out.close();
    file.commit();
}

int read_checkpoint(const std::string& path, Simulation& sim, const Sounding& sounding)
{
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError(path + ": cannot read the checkpoint");
    Digesting digesting(in.rdbuf());
    std::istream stream(&digesting);
    char head[32] = {};
    stream.read(head, std::streamsize(std::strlen(magic)));
    if (std::strcmp(head, magic) != 0)
        throw IoError(path + ": not a checkpoint of this version of cloudsim: expected '" + printable(magic) +
                      "' at its start; remove the file to start anew");
    uint64_t length = 0;
    stream.read(reinterpret_cast<char*>(&length), 8);
    if (!stream || length > (1u << 26)) throw IoError(path + ": damaged checkpoint");
    std::string text(length, ' ');
    stream.read(text.data(), std::streamsize(length));
    std::istringstream theirs(text), ours(text_of(sim.parameters(), sounding));
    for (;;) {
        std::string a, b;
        const bool more_theirs = bool(std::getline(theirs, a)), more_ours = bool(std::getline(ours, b));
        if (!more_theirs && !more_ours) break;
        if (a != b)
            throw UsageError(path + ": the checkpoint has '" + printable(a, 100) + "', this run has '" +
                             printable(b, 100) + "': expected equal parameters");
    }
    int frame = 0;
    stream.read(reinterpret_cast<char*>(&frame), sizeof frame);
    try {
        sim.restore(stream);
    } catch (const InputError&) {
        throw IoError(path + ": damaged checkpoint: the file ends too early");
    }
    const std::string expected = digesting.checksum();
    std::string found(checksum_size, ' ');
    in.read(found.data(), std::streamsize(found.size()));
    if (!in || found != expected) throw IoError(path + ": damaged checkpoint: wrong checksum");
    return frame;
}

}  // namespace vdbcloud::sim
