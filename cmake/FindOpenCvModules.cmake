# The few OpenCV modules that culm links, found without OpenCV's own configuration file: Debian ships
# that only with the package of all modules. Defines OpenCv::core, ::imgproc, ::imgcodecs, ::videoio.
include(FindPackageHandleStandardArgs)
find_path(OpenCvModules_INCLUDE_DIR opencv2/core/version.hpp PATH_SUFFIXES opencv4)
set(_opencv_variables OpenCvModules_INCLUDE_DIR)
foreach(module core imgproc imgcodecs videoio)
    find_library(OpenCvModules_${module}_LIBRARY opencv_${module})
    list(APPEND _opencv_variables OpenCvModules_${module}_LIBRARY)
endforeach()
if(OpenCvModules_INCLUDE_DIR)
    set(_opencv_header ${OpenCvModules_INCLUDE_DIR}/opencv2/core/version.hpp)
    file(STRINGS ${_opencv_header} _opencv_lines REGEX "#define CV_VERSION_(MAJOR|MINOR|REVISION) ")
    string(REGEX REPLACE "[^0-9;]" "" _opencv_numbers "${_opencv_lines}")
    list(JOIN _opencv_numbers "." OpenCvModules_VERSION)
endif()
find_package_handle_standard_args(OpenCvModules REQUIRED_VARS ${_opencv_variables}
    VERSION_VAR OpenCvModules_VERSION)
if(OpenCvModules_FOUND)
    foreach(module core imgproc imgcodecs videoio)
        if(NOT TARGET OpenCv::${module})
            add_library(OpenCv::${module} UNKNOWN IMPORTED)
            set_target_properties(OpenCv::${module} PROPERTIES
                IMPORTED_LOCATION ${OpenCvModules_${module}_LIBRARY}
                INTERFACE_INCLUDE_DIRECTORIES ${OpenCvModules_INCLUDE_DIR})
        endif()
    endforeach()
endif()
mark_as_advanced(${_opencv_variables})
