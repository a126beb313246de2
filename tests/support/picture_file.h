#pragma once
// Pictures that a program wrote, read by OpenEXR: a program that loads OpenImageIO starts in a quarter of a second.
#include <map>
#include <string>
#include <vector>

namespace vdbcloud::test {

struct PictureFile {
    int x = 0, y = 0, width = 0, height = 0;  ///< the window of pixels
    int full_width = 0;                       ///< of the picture of which the window is a part
    std::vector<std::string> channels;        ///< R, G, B, A first
    std::vector<float> pixels;                ///< [height][width][channels]
    std::map<std::string, std::string> texts;
    std::map<std::string, double> numbers;

    /// Index of a channel; -1 if there is none.
    int channel(const std::string& name) const;
    /// All pixels of a channel; empty if there is none.
    std::vector<float> layer(const std::string& name) const;
    /// Value of channel `name` in pixel (i, j) of the whole picture; std::out_of_range if there is none.
    float at(int i, int j, const std::string& name) const;
    /// Metadata; "" or 0 if there is none.
    std::string text(const std::string& key) const;
    double number(const std::string& key) const;
    /// Whether channels, window and all values are equal; a value that is not a number equals itself.
    bool same_values(const PictureFile& other) const;
};

/// All of an .exr file; of a file of another format, what oiiotool makes of it. std::runtime_error if it is no picture.
PictureFile picture(const std::string& path);

}  // namespace vdbcloud::test
