#pragma once
// Output files that are there whole or not at all, and that leave nothing behind when a run dies.
#include <string>

namespace vdbcloud {

/// A file being written. For an ordinary target the bytes go to a hidden temporary in the same folder
/// (".STEM.RANDOM.EXTENSION", so that libraries which go by extension can be handed its name); commit() checks,
/// synchronises and renames it. A link is followed, so that it stays a link. A target that is there and is no
/// regular file (a device, a fifo) is written directly.
///
/// The destructor removes a temporary that was not committed. Not to be shared between threads.
class AtomicFile {
public:
    /// Opens for writing. Throws IoError (path first): a folder is in the way or missing, no permission, or
    /// `no_clobber` and the target exists.
    explicit AtomicFile(const std::string& path, bool no_clobber = false);
    ~AtomicFile();
    AtomicFile(const AtomicFile&) = delete;
    AtomicFile& operator=(const AtomicFile&) = delete;

    int descriptor() const { return descriptor_; }

    /// What to open instead of the target, for libraries that want a name.
    const std::string& name() const { return name_; }

    /// False where the target is a device or a fifo: write front to back.
    bool seekable() const { return slot_ >= 0; }

    /// Makes the file appear under its path. Throws IoError if the disk refuses, or if no_clobber and the target
    /// came to exist meanwhile.
    void commit();

private:
    void close_descriptor();
    void forget_temporary(bool remove);

    std::string path_;    // as the user named it, for messages
    std::string target_;  // with links followed
    std::string name_;
    bool no_clobber_;
    int descriptor_ = -1;
    int slot_ = -1;  // in the table of temporaries; -1: written directly
};

/// Removes every temporary of this process. Safe to call from a signal handler; nothing may be written afterwards.
void remove_temporaries() noexcept;

/// "PATH: WHAT: REASON" for the system's error number `code`, as the message of an IoError.
std::string system_message(const std::string& path, const std::string& what, int code);

}  // namespace vdbcloud
