#pragma once
// Options for an environment: a picture of all directions as a sky and as suns.
#include "app.h"

#include "vdbcloud/scene/light.h"
#include "vdbcloud/scene/panorama.h"

#include <memory>
#include <vector>

namespace vdbcloud::app {

struct EnvironmentOptions {
    std::string path;  ///< of the picture; empty: none
    double turn = 0, gain = 1;
    bool asked() const { return !path.empty(); }

    /// The picture, read once. Throws IoError and InputError, path first.
    const std::shared_ptr<const Panorama>& panorama() const;
    /// Its suns as lights; none without a picture.
    std::vector<Light> suns(const Vec3d& up) const;

private:
    mutable std::shared_ptr<const Panorama> read_;
};

/// --environment --environment-turn --environment-gain.
void declare_environment(App&, EnvironmentOptions&);

}  // namespace vdbcloud::app
