# What `cmake --install` installs: the library with its public headers, CMake package and pkg-config file; the programs,
# behind the one command `vdbcloud`; manual pages, completions, licence and documents. tests/install builds against it.
include(CMakePackageConfigHelpers)
set(package_folder ${CMAKE_INSTALL_LIBDIR}/cmake/vdbcloud)

install(TARGETS vdbcloud EXPORT vdbcloud INCLUDES DESTINATION ${CMAKE_INSTALL_INCLUDEDIR})
install(TARGETS vdbcloud_openimageio LIBRARY DESTINATION ${vdbcloud_module_folder})
install(EXPORT vdbcloud FILE vdbcloudTargets.cmake NAMESPACE vdbcloud:: DESTINATION ${package_folder})
configure_package_config_file(cmake/vdbcloudConfig.cmake.in vdbcloudConfig.cmake INSTALL_DESTINATION ${package_folder})
write_basic_package_version_file(vdbcloudConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES
    ${CMAKE_CURRENT_BINARY_DIR}/vdbcloudConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/vdbcloudConfigVersion.cmake
    cmake/vdbcloudDependencies.cmake cmake/FindFFTW.cmake cmake/FindNetCDF.cmake cmake/FindXxHash.cmake
    DESTINATION ${package_folder})

file(RELATIVE_PATH pkgconfig_to_prefix /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
string(REGEX REPLACE "/$" "" pkgconfig_to_prefix "${pkgconfig_to_prefix}")
get_target_property(pkgconfig_definitions OpenVDB::openvdb INTERFACE_COMPILE_DEFINITIONS)
list(TRANSFORM pkgconfig_definitions PREPEND -D)
list(JOIN pkgconfig_definitions " " pkgconfig_definitions)
configure_file(cmake/vdbcloud.pc.in vdbcloud.pc @ONLY)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/vdbcloud.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)

install(CODE "set(from \"${CMAKE_CURRENT_SOURCE_DIR}/libvdbcloud/vdbcloud\")
    set(to \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_INCLUDEDIR}/vdbcloud\")
    include(\"${CMAKE_CURRENT_SOURCE_DIR}/cmake/install-headers.cmake\")")

get_property(programs GLOBAL PROPERTY vdbcloud_programs)
install(CODE "set(programs \"${programs}\")
    set(bin \"${CMAKE_RUNTIME_OUTPUT_DIRECTORY}\")
    set(man \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_MANDIR}/man1\")
    set(data \"\${CMAKE_INSTALL_PREFIX}/${CMAKE_INSTALL_DATAROOTDIR}\")
    include(\"${CMAKE_CURRENT_SOURCE_DIR}/cmake/install-generated.cmake\")")

install(FILES LICENSE README.md CHANGES.md CITATION.cff DESTINATION ${CMAKE_INSTALL_DOCDIR})
install(DIRECTORY docs DESTINATION ${CMAKE_INSTALL_DOCDIR})
