# The target headers_alone: every header of the library, the programs and the tests' support compiles alone. A header
# that comes or goes changes its folder, and that configures again.
add_library(headers_alone OBJECT EXCLUDE_FROM_ALL)
target_link_libraries(headers_alone PRIVATE vdbcloud_app GTest::gtest OpenEXR::OpenEXR FFTW::fftw3)
target_include_directories(headers_alone PRIVATE ${CMAKE_SOURCE_DIR}/tests ${CMAKE_SOURCE_DIR}/apps)
target_compile_options(headers_alone PRIVATE -O0)  # nothing runs; a header that defines little compiles to nothing

file(GLOB_RECURSE headers RELATIVE ${CMAKE_SOURCE_DIR}
    ${CMAKE_SOURCE_DIR}/libvdbcloud/*.h ${CMAKE_SOURCE_DIR}/apps/*.h ${CMAKE_SOURCE_DIR}/tests/*.h)
foreach(header IN LISTS headers)
    set(source ${CMAKE_CURRENT_BINARY_DIR}/headers_alone/${header}.cc)
    file(CONFIGURE OUTPUT ${source} CONTENT "#include \"${CMAKE_SOURCE_DIR}/${header}\"\n" @ONLY)
    target_sources(headers_alone PRIVATE ${source})
endforeach()

file(GLOB_RECURSE folders LIST_DIRECTORIES true
    ${CMAKE_SOURCE_DIR}/libvdbcloud/* ${CMAKE_SOURCE_DIR}/apps/* ${CMAKE_SOURCE_DIR}/tests/*)
foreach(folder IN LISTS folders)
    if(IS_DIRECTORY ${folder})
        set_property(DIRECTORY APPEND PROPERTY CMAKE_CONFIGURE_DEPENDS ${folder})
    endif()
endforeach()
