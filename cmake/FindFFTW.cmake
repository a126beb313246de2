# FFTW in double and in single precision: FFTW::fftw3 and FFTW::fftw3f. Debian's FFTW has no usable config package.
find_path(FFTW_INCLUDE_DIR fftw3.h)
find_library(FFTW_fftw3_LIBRARY fftw3)
find_library(FFTW_fftw3f_LIBRARY fftw3f)
mark_as_advanced(FFTW_INCLUDE_DIR FFTW_fftw3_LIBRARY FFTW_fftw3f_LIBRARY)
include(FindPackageHandleStandardArgs)
find_package_handle_standard_args(FFTW REQUIRED_VARS FFTW_fftw3_LIBRARY FFTW_fftw3f_LIBRARY FFTW_INCLUDE_DIR)
if(FFTW_FOUND)
    foreach(name fftw3 fftw3f)
        if(NOT TARGET FFTW::${name})
            add_library(FFTW::${name} UNKNOWN IMPORTED)
            set_target_properties(FFTW::${name} PROPERTIES
                IMPORTED_LOCATION ${FFTW_${name}_LIBRARY}
                INTERFACE_INCLUDE_DIRECTORIES ${FFTW_INCLUDE_DIR})
        endif()
    endforeach()
endif()
