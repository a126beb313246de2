#include "fuzz.h"

#include "scene_file.h"

#include "vdbcloud/core/error.h"

namespace vdbcloud::test {

/// What a program takes of any bytes is a scene file of which it takes the same.
void judge(std::string_view bytes)
{
    static const auto programs = app::scene_programs();
    for (const auto& program : programs) {
        static const app::SceneReader readers[] = {app::SceneReader(*programs[0]), app::SceneReader(*programs[1]),
                                                   app::SceneReader(*programs[2])};
        const app::SceneReader& reader = readers[&program - &programs[0]];
        const std::string part = scene_text(*program, reader.read(std::string(bytes)));
        demand(scene_text(*program, reader.read(part)) == part, "the part of the part");
    }
}

}  // namespace vdbcloud::test
