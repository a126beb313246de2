#pragma once
// Output files that appear complete or not at all. A failed run leaves no temporary files.
#include <functional>
#include <string>

namespace vdbcloud {

/// A file being written.
///
/// The bytes go to a hidden temporary in the target's folder; commit() checks, synchronises and renames the temporary.
/// The temporary is called ".STEM.RANDOM.EXTENSION", because some libraries choose the format by the extension. A
/// symbolic link is followed and stays a link. An existing target that is not a regular file (a device, a fifo) is
/// written directly, without a temporary.
///
/// The destructor removes a temporary without commit(). Not to be shared between threads.
class AtomicFile {
public:
    /// Opens for writing. Throws IoError beginning with the path. Causes: the target is a folder, the target's folder
    /// does not exist, the permission is missing, or the target exists and `no_clobber` is true.
    explicit AtomicFile(const std::string& path, bool no_clobber = false);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    int descriptor() const { return descriptor_; }

    /// Path of the file to write to, for libraries that open files by name: the temporary, or the device or fifo.
    const std::string& name() const { return name_; }

    /// False if the target is a device or a fifo: write the bytes in order.
    bool seekable() const { return slot_ >= 0; }

    /// Makes the file appear under its path. Throws IoError if the system reports a write error, or if no_clobber is
    /// true and another process has created the target since the constructor.
    void commit();

private:
    void close_descriptor();
    void forget_temporary(bool remove);

    std::string path_;    // path given by the user, for messages
    std::string target_;  // path_ with symbolic links followed
    std::string name_;
    bool no_clobber_;
    int descriptor_ = -1;
    int slot_ = -1;  // index in the table of temporaries; -1: no temporary
};

/// Removes every temporary of this process. Safe to call from a signal handler; nothing may be written afterwards.
void remove_temporaries() noexcept;

/// Removes temporaries that killed processes left in `folder`: those of targets for whose file name `ours` is true. A
/// temporary that a process still writes stays. Failures are ignored. For all files of a folder that are one run's.
void remove_stale_temporaries(const std::string& folder, const std::function<bool(const std::string& target)>& ours);

/// A mark that a run of this process writes to `path`, as long as the object lives: the hidden file ".NAME.lock" beside
/// the path, locked by the system, so that the mark of a killed run is none. Removed at the end and by signals. No mark
/// where the file system has no locks. Not to be shared between threads.
class RunLock {
public:
    /// Throws IoError, which names process and host, if another run has the mark, or if the folder cannot be written.
    explicit RunLock(const std::string& path);
    ~RunLock();
    RunLock(const RunLock&) = delete;
    RunLock& operator=(const RunLock&) = delete;

private:
    std::string name_;
    int descriptor_ = -1;
    int slot_ = -1;  // index in the table of temporaries
};

/// The file at the end of a chain of symbolic links, whether the file exists or not; `path` itself if it is no link.
std::string link_target(const std::string& path);

/// A hidden name beside `target` that cannot be guessed: ".STEM.RANDOM.EXTENSION". Open it with O_EXCL | O_NOFOLLOW.
std::string temporary_name(const std::string& target);

/// "PATH: WHAT: REASON" for the system's error number `code`, as the message of an IoError.
std::string system_message(const std::string& path, const std::string& what, int code);

}  // namespace vdbcloud
