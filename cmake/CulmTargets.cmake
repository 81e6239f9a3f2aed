# One library per folder of src, with the arrows of the layer diagram as its only links.

# The flags that every culm target shares: warnings, sanitizers, architecture.
add_library(culm_build_flags INTERFACE)
target_compile_features(culm_build_flags INTERFACE cxx_std_20)
# GCC 12 reports false uninitialised reads inside <experimental/simd> and Eigen with AVX-512.
target_compile_options(culm_build_flags INTERFACE
    "$<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic;-Wshadow;-Wconversion>"
    "$<BUILD_INTERFACE:-Wnon-virtual-dtor;-Woverloaded-virtual>"
    "$<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-uninitialized>>")
if(CULM_WARNINGS_AS_ERRORS)
    target_compile_options(culm_build_flags INTERFACE "$<BUILD_INTERFACE:-Werror>")
endif()
if(CULM_ARCHITECTURE)
    target_compile_options(culm_build_flags INTERFACE -march=${CULM_ARCHITECTURE})
endif()
if(CULM_SANITIZE)
    target_compile_options(culm_build_flags INTERFACE
        -fsanitize=${CULM_SANITIZE} -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(culm_build_flags INTERFACE -fsanitize=${CULM_SANITIZE})
endif()
# Packaged libraries are compiled for the baseline architecture: Eigen objects may only cross that
# border if both sides agree on their alignment.
target_compile_definitions(culm_build_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16)

# culm_precompile(<target> <header>...): other projects' headers that most of its files read are parsed
# once, which takes a tenth to a fifth off a file. ccache cannot keep what such a header is part of, and
# saves more; so a build with it compiles every file from its own includes and shows the one that is missing.
function(culm_precompile target)
    if(NOT CMAKE_CXX_COMPILER_LAUNCHER MATCHES "ccache")
        target_precompile_headers(${target} PRIVATE ${ARGN})
    endif()
endfunction()

# culm_add_layer(<folder> SOURCES ... LINKS ... [PRECOMPILED header...]): the library culm_<folder>, alias culm::<folder>.
function(culm_add_layer folder)
    cmake_parse_arguments(ARG "" "" "SOURCES;LINKS;PRECOMPILED" ${ARGN})
    add_library(culm_${folder} STATIC ${ARG_SOURCES})
    add_library(culm::${folder} ALIAS culm_${folder})
    target_include_directories(culm_${folder} PUBLIC
        "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>" "$<INSTALL_INTERFACE:include/culm>")
    target_link_libraries(culm_${folder} PUBLIC culm_build_flags ${ARG_LINKS})
    if(ARG_PRECOMPILED)
        culm_precompile(culm_${folder} ${ARG_PRECOMPILED})
    endif()
endfunction()
