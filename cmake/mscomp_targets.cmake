# What every target of ours is made with.

# Compiling, for us alone: nothing of it reaches who uses an installed library.
add_library(mscomp_options INTERFACE)
target_include_directories(mscomp_options INTERFACE "${CMAKE_CURRENT_LIST_DIR}/../include"
                                                    "${CMAKE_CURRENT_LIST_DIR}/../src")
target_compile_options(mscomp_options INTERFACE -Wall -Wextra -Wpedantic -Wshadow -Wnon-virtual-dtor
                                                -Woverloaded-virtual -Werror -fno-math-errno)
target_compile_definitions(mscomp_options INTERFACE EIGEN_DONT_PARALLELIZE)
if(MSCOMP_NATIVE)
    target_compile_options(mscomp_options INTERFACE -march=native)
endif()
if(MSCOMP_SANITIZE)
    # GCC takes the sanitizers' own checks for uses of uninitialised memory.
    target_compile_options(mscomp_options INTERFACE
        -fsanitize=${MSCOMP_SANITIZE} -fno-omit-frame-pointer
        $<$<CXX_COMPILER_ID:GNU>:-Wno-maybe-uninitialized>)
    target_link_options(mscomp_options INTERFACE -fsanitize=${MSCOMP_SANITIZE})
    target_compile_definitions(mscomp_options INTERFACE MSCOMP_SANITIZED)
endif()
if(MSCOMP_FUZZ)
    # Every report stops the run, and indices of vectors and spans are checked.
    target_compile_options(mscomp_options INTERFACE -fno-sanitize-recover=all)
    target_compile_definitions(mscomp_options INTERFACE _GLIBCXX_ASSERTIONS)
endif()

# For sources that work on many numbers at a time. Sanitized loops stay loops, of which clang warns.
set(mscomp_lanes "-O3")
if(MSCOMP_SANITIZE)
    set(mscomp_lanes "$<$<CXX_COMPILER_ID:Clang>:-Wno-pass-failed>")
endif()

option(MSCOMP_JOIN "Compile the sources of a target several at a time (docs/testing.md)" ON)

# mscomp_join(TARGET COUNT): its sources are compiled joined, so that headers are read and templates
# made once for COUNT of them. Sources with flags of their own stay apart, in CMake's own way.
function(mscomp_join target count)
    set_target_properties(${target} PROPERTIES UNITY_BUILD ${MSCOMP_JOIN}
                                               UNITY_BUILD_BATCH_SIZE ${count})
    if(MSCOMP_JOIN)
        # GCC takes a joined source for a header, where unnamed namespaces would be a mistake.
        target_compile_options(${target} PRIVATE $<$<CXX_COMPILER_ID:GNU>:-Wno-subobject-linkage>)
    endif()
endfunction()

# mscomp_words_only(TARGET): what it does is read options, write text and call others. Optimising that
# takes as long as compiling it, and nobody would notice.
function(mscomp_words_only target)
    target_compile_options(${target} PRIVATE $<$<CONFIG:Release>:-O1>)
endfunction()

# mscomp_library(NAME SOURCES ... [PUBLIC ...] [PRIVATE ...]): the module NAME, target mscomp_NAME,
# mscomp::NAME for others, and a component of the installed package (cmake/install.cmake). PUBLIC
# libraries are in its headers, PRIVATE ones are not.
function(mscomp_library name)
    cmake_parse_arguments(ARG "" "" "SOURCES;PUBLIC;PRIVATE" ${ARGN})
    # Templates that only our sources include are nothing to look for where we are installed.
    list(TRANSFORM ARG_PRIVATE REPLACE "^(Eigen3::Eigen|nlohmann_json::nlohmann_json)$"
                                       "$<BUILD_INTERFACE:\\1>")
    set_property(GLOBAL APPEND PROPERTY MSCOMP_LIBRARIES ${name})
    add_library(mscomp_${name} STATIC ${ARG_SOURCES})
    add_library(mscomp::${name} ALIAS mscomp_${name})
    set_target_properties(mscomp_${name} PROPERTIES EXPORT_NAME ${name}
                                                    POSITION_INDEPENDENT_CODE ON)
    target_include_directories(mscomp_${name}
                               PUBLIC "$<BUILD_INTERFACE:${CMAKE_CURRENT_FUNCTION_LIST_DIR}/../include>"
                                      "$<INSTALL_INTERFACE:${CMAKE_INSTALL_INCLUDEDIR}>")
    target_compile_features(mscomp_${name} PUBLIC cxx_std_20)
    target_link_libraries(mscomp_${name} PUBLIC ${ARG_PUBLIC}
                                         PRIVATE $<BUILD_INTERFACE:mscomp_options> ${ARG_PRIVATE})
    mscomp_join(mscomp_${name} 12)
endfunction()

# mscomp_link_found(TARGET LIBRARY NAMES...): a library without a package of its own, by the path
# at which it was found here, and by name for who uses an installed TARGET: "-lcholmod".
function(mscomp_link_found target library)
    foreach(path IN LISTS library)
        target_link_libraries(${target} PRIVATE $<BUILD_INTERFACE:${path}>)
    endforeach()
    target_link_libraries(${target} PRIVATE $<INSTALL_INTERFACE:${ARGN}>)
endfunction()

# mscomp_program(NAME SOURCES ... LIBRARIES ...): an executable of ours.
function(mscomp_program name)
    cmake_parse_arguments(ARG "" "" "SOURCES;LIBRARIES" ${ARGN})
    add_executable(${name} ${ARG_SOURCES})
    target_link_libraries(${name} PRIVATE mscomp_options ${ARG_LIBRARIES})
    mscomp_words_only(${name})
    mscomp_join(${name} 12)
endfunction()
