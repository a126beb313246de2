#pragma once
// The certificate of a picture: its options, and what is printed, reported and written of it.
#include "output.h"

#include "vdbcloud/render/certificate.h"

namespace vdbcloud {

/// Declares --certify, --correct and --error-png.
void declare_certificate(app::App&, RenderOptions&, const std::string& group);

/// "30" [s], "0.5%", or "0.5%,30".
CertifyOptions certify_options(const RenderOptions&);

/// Memory of the light paths beyond that of the picture [bytes].
double certificate_bytes(const RenderOptions&, const LoadedScene&, const Film&);
/// Work of the light paths, by a pilot of rays.
Workload certificate_work(const app::App&, const RenderOptions&, const LoadedScene&, const Film&, const CameraView&);

/// Certifies the picture: prints and reports the errors. Where the paths are too noisy, says so.
Certificate certify_picture(app::App&, const RenderOptions&, const LoadedScene&, Film&, const CameraView&);

/// The errors as attributes of the picture.
void stamp_certificate(ImageMetadata&, const Certificate&, bool corrected);

/// Writes --error-png: the blocks' errors in false colours.
void write_error_png(app::App&, const RenderOptions&, const Film&, const Certificate&, const CameraView&,
                     const ImageMetadata&);

/// Throws ConvergenceError if the half-width asked for was not reached in time. To be called when all is written.
void require_reached(const RenderOptions&, const Certificate&);

}  // namespace vdbcloud
