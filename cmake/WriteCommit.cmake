# Writes OUTPUT, a header with the commit of SOURCE; leaves it alone if nothing changed.
execute_process(COMMAND git -C ${SOURCE} describe --always --dirty
    OUTPUT_VARIABLE commit OUTPUT_STRIP_TRAILING_WHITESPACE ERROR_QUIET)
file(CONFIGURE OUTPUT ${OUTPUT} @ONLY CONTENT
"// Written by CMake at every build.
#pragma once
namespace culm::bench {
inline constexpr const char* commit = \"@commit@\";
}
")
