# Every library we stand on, found once. docs/dependencies.md says why each.
set(CMAKE_FIND_PACKAGE_NAME vdbcloud)  # find_dependency asks whether this package is required
set(vdbcloud_FIND_REQUIRED TRUE)
include(${CMAKE_CURRENT_LIST_DIR}/vdbcloudDependencies.cmake)
unset(CMAKE_FIND_PACKAGE_NAME)

# The programs' own, the module's, and header-only ones of the library's sources: users of the installed library do not need them.
find_package(CLI11 REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)
find_package(Eigen3 REQUIRED NO_MODULE)

# Debian's OpenImageIO target names an include folder of OpenCV, which is there only with OpenCV.
foreach(target OpenImageIO::OpenImageIO OpenImageIO::OpenImageIO_Util)
    get_target_property(folders ${target} INTERFACE_INCLUDE_DIRECTORIES)
    if(folders)
        set(kept)
        foreach(folder IN LISTS folders)
            if(EXISTS ${folder})
                list(APPEND kept ${folder})
            endif()
        endforeach()
        set_target_properties(${target} PROPERTIES INTERFACE_INCLUDE_DIRECTORIES "${kept}")
    endif()
endforeach()
