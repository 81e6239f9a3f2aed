# One library per folder of src, with the arrows of the layer diagram as its only links.

# The flags that every culm target shares: warnings, sanitizers, architecture.
add_library(culm_build_flags INTERFACE)
target_compile_features(culm_build_flags INTERFACE cxx_std_20)
# GCC 12 reports false uninitialised reads inside <experimental/simd> and Eigen with AVX-512.
target_compile_options(culm_build_flags INTERFACE
    "$<BUILD_INTERFACE:-Wall;-Wextra;-Wpedantic;-Wconversion>"
    "$<BUILD_INTERFACE:-Wnon-virtual-dtor;-Woverloaded-virtual>"
    "$<BUILD_INTERFACE:$<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized;-Wno-uninitialized>>")
if(CULM_WARNINGS_AS_ERRORS)
    target_compile_options(culm_build_flags INTERFACE "$<BUILD_INTERFACE:-Werror>")
endif()
if(CULM_ARCHITECTURE)
    target_compile_options(culm_build_flags INTERFACE -march=${CULM_ARCHITECTURE})
endif()
# Simulations of chains take the time of studies and diagnoses. Targets without such loops compile
# faster with -O1 and run as fast; -fexpensive-optimizations keeps fused multiplication there.
define_property(TARGET PROPERTY CULM_SIMULATES BRIEF_DOCS "Is the target compiled with -O3?")
target_compile_options(culm_build_flags INTERFACE "$<BUILD_INTERFACE:$<$<AND:$<CONFIG:Release>,$<NOT:$<BOOL:$<TARGET_PROPERTY:CULM_SIMULATES>>>>:-O1;-fexpensive-optimizations>>")
# GCC's checks for null and for the size of objects find nothing that the address sanitizer misses, and
# with them one source of integrate/ compiles for more than five minutes.
if(CULM_SANITIZE)
    target_compile_options(culm_build_flags INTERFACE
        -fsanitize=${CULM_SANITIZE} -fno-sanitize=null,object-size
        -fno-sanitize-recover=all -fno-omit-frame-pointer)
    target_link_options(culm_build_flags INTERFACE -fsanitize=${CULM_SANITIZE})
endif()
# Packaged libraries are compiled for the baseline architecture: Eigen objects may only cross that
# border if both sides agree on their alignment.
target_compile_definitions(culm_build_flags INTERFACE EIGEN_MAX_ALIGN_BYTES=16)

# Sums must not depend on where the heap puts a vector (src/core/aligned_heap.cpp). A sanitizer has a heap
# of its own.
if(CMAKE_SYSTEM_NAME STREQUAL "Linux" AND NOT CULM_SANITIZE AND NOT CULM_FUZZ)
    target_link_options(culm_build_flags INTERFACE -Wl,--wrap=malloc,--wrap=realloc)
endif()

# Most of a file's compile time goes into other projects' headers and templates: the sources of a library
# are compiled together, which instantiates them once. A tool that reads files one by one (clang-tidy) turns
# this off, and so does the preset `dev`, where one changed source must not compile a library again.
option(CULM_GROUP_SOURCES "Compile the sources of a library together" ON)
function(culm_group_sources target)
    if(CULM_GROUP_SOURCES)
        set_target_properties(${target} PROPERTIES UNITY_BUILD ON UNITY_BUILD_BATCH_SIZE 0)
    endif()
endfunction()

# Sources that are compiled with -O3 in a target that is not: their loops show in a profile.
function(culm_optimise)
    set_source_files_properties(${ARGN} PROPERTIES SKIP_UNITY_BUILD_INCLUSION ON
        COMPILE_OPTIONS "$<$<CONFIG:Release>:-O3>")
endfunction()

# In a group a local name may equal that of a constant of another file, which is harmless.
if(CULM_GROUP_SOURCES AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
    target_compile_options(culm_build_flags INTERFACE "$<BUILD_INTERFACE:-Wshadow=local>")
else()
    target_compile_options(culm_build_flags INTERFACE "$<BUILD_INTERFACE:-Wshadow>")
endif()

# culm_add_layer(<folder> [SIMULATES] SOURCES ... LINKS ...): the library culm_<folder>, alias
# culm::<folder>.
function(culm_add_layer folder)
    cmake_parse_arguments(ARG "SIMULATES" "" "SOURCES;LINKS" ${ARGN})
    add_library(culm_${folder} STATIC ${ARG_SOURCES})
    add_library(culm::${folder} ALIAS culm_${folder})
    target_include_directories(culm_${folder} PUBLIC
        "$<BUILD_INTERFACE:${PROJECT_SOURCE_DIR}/src>" "$<INSTALL_INTERFACE:include/culm>")
    target_link_libraries(culm_${folder} PUBLIC culm_build_flags ${ARG_LINKS})
    set_target_properties(culm_${folder} PROPERTIES CULM_SIMULATES ${ARG_SIMULATES})
    culm_group_sources(culm_${folder})
endfunction()
