// The options of the certificate (certify.h).
#include "certify.h"
#include "formed.h"

#include <optional>

namespace vdbcloud {

namespace {

/// Nothing if `text` is of another form.
std::optional<CertifyOptions> read_certify(const std::string& text)
{
    CertifyOptions out;
    for (std::string word : app::split(text, ',')) {
        const bool share = !word.empty() && word.back() == '%';
        if (share) word.pop_back();
        const auto x = app::number(word);
        double& to = share ? out.half_width : out.seconds;
        if (!x || !(*x > 0) || !(*x < 1e9) || to > 0) return std::nullopt;
        to = share ? *x / 100 : *x;
    }
    return out;
}

}  // namespace

void declare_certificate(app::App& app, RenderOptions& o, const std::string& group)
{
    o.option.certify =
        app.add_option(
               "--certify", o.certify,
               "measure the picture's error against light paths: for so many seconds (30), until the error over 32x32 "
               "pixels is known to so much (0.5%), or whichever comes first (0.5%,30). Prints the error and its 95 % "
               "interval; the .exr gets layers block_error and block_deviation")
            ->check(app::formed("seconds (30), a half-width of the error (0.5%), or both (0.5%,30)",
                                [](const std::string& text) { return read_certify(text).has_value(); }))
            ->not_with([&o] { return !shows_light_grids(o); }, "--integrator path, whose layer standard_error says it")
            ->type_name("TEXT")
            ->default_str("")
            ->scene("accuracy")
            ->group(group);
    app.add_flag("--correct", o.correct,
                 "take the errors that --certify finds off the picture, shrunk by their noise; the certificate is then "
                 "that of the corrected picture, by paths that its correction has not seen")
        ->needs(o.option.certify)
        ->scene("accuracy")
        ->group(group);
    app.add_option("--error-png", o.error_png,
                   "the errors of blocks of 8x8 pixels in false colours: red too bright, blue too dark")
        ->needs(o.option.certify)
        ->type_name("FILE")
        ->writes_file(app::FileKind::Png)
        ->configurable(false)
        ->group(group);
}

CertifyOptions certify_options(const RenderOptions& o)
{
    CertifyOptions out = read_certify(o.certify).value();
    out.correct = o.correct;
    return out;
}

}  // namespace vdbcloud
