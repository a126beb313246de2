# Every library we stand on, found once. docs/dependencies.md says why each.
set(OpenVDB_MODULE_DIR "" CACHE PATH "Folder of FindOpenVDB.cmake, if CMake does not find it")
# OpenVDB ships a find module, not a config package; distributions put it beside their CMake configs.
file(GLOB openvdb_modules /usr/lib/*/cmake/OpenVDB /usr/lib/cmake/OpenVDB /usr/local/lib/cmake/OpenVDB)
list(APPEND CMAKE_MODULE_PATH ${OpenVDB_MODULE_DIR} ${openvdb_modules})

find_package(OpenVDB REQUIRED)
find_package(TBB REQUIRED)
find_package(OpenImageIO REQUIRED)
find_package(CLI11 REQUIRED)
find_package(nlohmann_json REQUIRED)
find_package(tomlplusplus REQUIRED)

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

# FFTW has no usable config package in Debian: double and single precision, no threads of its own.
find_path(FFTW_INCLUDE_DIR fftw3.h REQUIRED)
find_library(FFTW_LIBRARY fftw3 REQUIRED)
find_library(FFTWF_LIBRARY fftw3f REQUIRED)
add_library(fftw INTERFACE)
target_include_directories(fftw INTERFACE ${FFTW_INCLUDE_DIR})
target_link_libraries(fftw INTERFACE ${FFTW_LIBRARY} ${FFTWF_LIBRARY})
