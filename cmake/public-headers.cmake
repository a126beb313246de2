# Headers that users include, and that the programs in apps/ include. The headers that these include are public, too.
# All other headers are the library's own; those that begin with "Private to MODULE/" serve one module alone.
# tests/layering.cmake checks both.
set(public_headers
    core/atomic_file.h core/constants.h core/control_groups.h core/effects.h core/error.h core/memory.h core/number_range.h core/of_file.h core/progress.h core/shortest.h core/vdb.h core/workload.h
    grid/compare.h grid/density.h grid/digest.h grid/emission.h grid/extent.h grid/grid_file.h grid/metadata.h grid/probe.h
    grid/registry.h grid/schema.h grid/select.h grid/sources.h grid/statistics.h grid/tree_size.h grid/up_axis.h
    voxels/box_medium.h voxels/cloud_table.h voxels/voxel_mean.h
    file/io.h file/table.h file/text.h
    exchange/array_file.h exchange/cloud_field.h exchange/export_netcdf.h exchange/nanovdb_file.h exchange/netcdf_tables.h exchange/particles.h exchange/property_file.h exchange/usd.h
    optics/automatic_extinction.h optics/joined_medium.h optics/medium.h optics/mixture.h optics/optical_depth.h optics/phase_function.h optics/solid_rays.h optics/thermal_emission.h
    effects/effects.h
    scene/atmosphere.h scene/blackbody.h scene/camera.h scene/colour.h scene/light.h scene/panorama.h scene/sky.h scene/solid.h
    light/transmittance_grid.h
    scatter/expected_share.h scatter/multiple_scattering.h scatter/scatter_plan.h scatter/series_grids.h scatter/voxel_error.h
    render/certificate.h render/image_in.h render/image_out.h render/integrator.h render/merge.h render/render_plan.h render/scene_digest.h
    sim/checkpoint.h sim/effect.h sim/large_scale.h sim/presets.h sim/simulation.h sim/snapshot.h sim/sounding.h sim/statistics.h sim/step_plan.h sim/words.h
    fractal/cloud_grid.h fractal/cloud_shape.h fractal/cumulus.h fractal/detail.h fractal/mask_envelope.h fractal/mountain.h)

# Sets `result` to public_headers and every header that they include, of the folder `from`.
function(find_public_headers result from)
    set(found)
    set(headers ${public_headers})
    while(headers)
        list(POP_FRONT headers header)
        if(header IN_LIST found)
            continue()
        endif()
        if(NOT EXISTS ${from}/${header})
            message(FATAL_ERROR "cmake/public-headers.cmake: no public header ${from}/${header}")
        endif()
        list(APPEND found ${header})
        file(STRINGS ${from}/${header} lines REGEX "^ *# *include *\"vdbcloud/")
        foreach(line IN LISTS lines)
            string(REGEX REPLACE ".*\"vdbcloud/([^\"]*)\".*" "\\1" included "${line}")
            list(APPEND headers ${included})
        endforeach()
    endwhile()
    set(${result} ${found} PARENT_SCOPE)
endfunction()
