#include "vdbcloud/sim/checkpoint.h"

#include "vdbcloud/core/atomic_file.h"
#include "vdbcloud/core/error.h"
#include "vdbcloud/grid/digest.h"

#include <algorithm>
#include <cstring>
#include <filesystem>
#include <fstream>
#include <sstream>

namespace vdbcloud::sim {

namespace {

constexpr const char* magic = "VDBCLOUD CHECKPOINT 7\n";
constexpr size_t checksum_size = 32;

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

void put_text(std::ostream& out, const std::string& text)
{
    const uint64_t length = text.size();
    out.write(reinterpret_cast<const char*>(&length), 8);
    out.write(text.data(), std::streamsize(length));
}

/// Throws IoError, beginning with `path`, for a length that no checkpoint has.
std::string take_text(const std::string& path, std::istream& in)
{
    uint64_t length = 0;
    in.read(reinterpret_cast<char*>(&length), 8);
    if (!in || length > (1u << 26)) throw IoError(path + ": damaged checkpoint");
    std::string text(length, ' ');
    in.read(text.data(), std::streamsize(length));
    return text;
}

std::vector<std::string> lines_of(const std::string& text)
{
    std::vector<std::string> lines;
    std::istringstream in(text);
    for (std::string line; std::getline(in, line);) lines.push_back(line);
    return lines;
}

/// "name = value" lines. Whether a value can change is the running program's to say.
RunRecord record_of(const std::string& values, const std::string& changes)
{
    RunRecord record;
    for (const std::string& line : lines_of(values)) {
        const size_t equals = std::min(line.find(" = "), line.size());
        record.values.push_back({line.substr(0, equals), line.substr(std::min(line.size(), equals + 3)), false});
    }
    record.changes = lines_of(changes);
    return record;
}

/// Where frames go on after `frame` at `time` [s]: as before, or from there on if --every is another one or the earlier
/// run ended between two frames. Throws UsageError for the latter without `change`.
void continue_schedule(const std::string& path, const Schedule& before, int frame, double time, bool change,
                       Schedule& now)
{
    Schedule endless = before;
    endless.end = never;
    const double due = endless.time_of(frame);
    const bool between = time < due - 1e-9 * std::max(1.0, due) && now.end > time;
    if (between && !change)
        throw UsageError(path + ": the run ended at " + std::to_string(time) + " s, before its next frame was due at " +
                         std::to_string(due) + " s: expected equal --minutes, or --change for frames from here on");
    const bool anew = between || now.every != before.every;
    now.first = anew ? frame : before.first;
    now.start = anew ? time : before.start;
}

/// What stands before the state.
struct Head {
    RunRecord record;
    Schedule schedule;
    CheckpointPlace place{0, 0};
};

/// Reads from `stream`, whose bytes come from `in`; leaves both at the state.
Head read_head(const std::string& path, std::istream& in, std::istream& stream)
{
    char head[32] = {};
    stream.read(head, std::streamsize(std::strlen(magic)));
    if (std::strcmp(head, magic) != 0)
        throw IoError(path + ": not a checkpoint of this version of cloudsim: expected '" + printable(magic) +
                      "' at its start; to start anew give the path of a file that is not there");
    const std::string values = take_text(path, stream), changes = take_text(path, stream);
    Head read{record_of(values, changes), {}, {}};
    Schedule& before = read.schedule;
    for (double* value : {&before.every, &before.end, &before.start})
        stream.read(reinterpret_cast<char*>(value), sizeof *value);
    for (int* value : {&before.first, &read.place.frame}) stream.read(reinterpret_cast<char*>(value), sizeof *value);
    const std::streampos state = in.tellg();
    double& time = read.place.time;  // the first value of the state
    in.read(reinterpret_cast<char*>(&time), sizeof time);
    if (!in) throw IoError(path + ": damaged checkpoint: the file ends too early");
    in.seekg(state);
    return read;
}

std::ifstream opened(const std::string& path)
{
    std::error_code unknown;
    if (std::filesystem::exists(path, unknown) && !std::filesystem::is_regular_file(path, unknown))
        throw IoError(path + ": a folder or device: expected a checkpoint, a regular file");
    std::ifstream in(path, std::ios::binary);
    if (!in) throw IoError(path + ": cannot read the checkpoint");
    return in;
}

}  // namespace

void write_checkpoint(const std::string& path, const Simulation& sim, const RunRecord& record, const Schedule& schedule,
                      int frame, const std::string& statistics)
{
    AtomicFile file(path);
    std::ofstream out(file.name(), std::ios::binary | std::ios::trunc);
    Digesting digesting(out.rdbuf());
    std::ostream stream(&digesting);
    std::string changes;
    for (const std::string& change : record.changes) changes += change + "\n";
    stream << magic;
    put_text(stream, record.text());
    put_text(stream, changes);
    for (const double value : {schedule.every, schedule.end, schedule.start})
        stream.write(reinterpret_cast<const char*>(&value), sizeof value);
    for (const int value : {schedule.first, frame}) stream.write(reinterpret_cast<const char*>(&value), sizeof value);
    sim.save(stream);
    put_text(stream, statistics);
    out << digesting.checksum();
    out.flush();
    if (!stream || !out) throw IoError(path + ": cannot write the checkpoint (is the disk full?)");
    out.close();
    file.commit();
}

int read_checkpoint(const std::string& path, Simulation& sim, RunRecord& record, Schedule& schedule, bool change,
                    std::string* statistics)
{
    std::ifstream in = opened(path);
    Digesting digesting(in.rdbuf());
    std::istream stream(&digesting);
    const Head head = read_head(path, in, stream);
    // A parameter that differs is named before the state is read: the state of another lattice has another size.
    continue_record(path, head.record, head.place.time, change, record);
    try {
        sim.restore(stream);
    } catch (const InputError&) {
        throw IoError(path + ": damaged checkpoint: the file ends too early");
    }
    const std::string taken = take_text(path, stream);
    if (statistics) *statistics = taken;
    const std::string expected = digesting.checksum();
    std::string found(checksum_size, ' ');
    in.read(found.data(), std::streamsize(found.size()));
    if (!in || found != expected) throw IoError(path + ": damaged checkpoint: wrong checksum");
    continue_schedule(path, head.schedule, head.place.frame, sim.time(), change, schedule);
    return head.place.frame;
}

CheckpointPlace read_checkpoint_place(const std::string& path, RunRecord& record, Schedule& schedule, bool change)
{
    std::ifstream in = opened(path);
    const Head head = read_head(path, in, in);
    continue_record(path, head.record, head.place.time, change, record);
    continue_schedule(path, head.schedule, head.place.frame, head.place.time, change, schedule);
    return head.place;
}

}  // namespace vdbcloud::sim
