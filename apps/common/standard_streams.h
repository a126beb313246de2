#pragma once
// Standard input, output and error as the program finds them.
#include <string>

namespace vdbcloud::app {

/// Occupies descriptors 0 to 2 where the parent process closed them, so that no file of the program gets their number
/// and no message goes into a file. Reading from such a standard input, and writing to such a standard output, fails as
/// on a closed descriptor. Call first, before any file is opened.
void occupy_standard_descriptors();

/// Throws IoError if nothing can be written to standard output because it is closed.
void require_standard_output();

/// Writes a text to standard output. Throws IoError.
void to_standard_output(const std::string& text);

}  // namespace vdbcloud::app
