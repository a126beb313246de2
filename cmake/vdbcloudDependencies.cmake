# The libraries that a program linked with libvdbcloud needs. Two callers: this tree, and the installed
# vdbcloudConfig.cmake, beside which this file and the Find*.cmake of this folder are installed. A library that
# libvdbcloud links belongs here, and in cmake/vdbcloud.pc.in.
include(CMakeFindDependencyMacro)
set(OpenVDB_MODULE_DIR "" CACHE PATH "Folder of FindOpenVDB.cmake, if CMake does not find it")
set(vdbcloud_module_path ${CMAKE_MODULE_PATH})
# OpenVDB ships a find module, not a config package; distributions put it beside their CMake configs.
file(GLOB openvdb_modules /usr/lib/*/cmake/OpenVDB /usr/lib/cmake/OpenVDB /usr/local/lib/cmake/OpenVDB)
list(APPEND CMAKE_MODULE_PATH ${OpenVDB_MODULE_DIR} ${openvdb_modules} ${CMAKE_CURRENT_LIST_DIR})

find_dependency(OpenVDB)
find_dependency(TBB)
find_dependency(OpenEXR)
find_dependency(FFTW)
find_dependency(NetCDF)
find_dependency(XxHash)

set(CMAKE_MODULE_PATH ${vdbcloud_module_path})
