# What `cmake --install` puts where, and how others find it: a CMake package whose components are
# the modules, a file for pkg-config, manual pages and completions. Included last.
include(CMakePackageConfigHelpers)

# Where CMake and pkg-config find what a module of ours is linked with, one row per target:
# target | arguments of find_dependency | package of pkg-config | or words for the linker
set(mscomp_sources
    "Ceres::ceres|Ceres||-lceres -lglog"
    "CLI11::CLI11|CLI11|CLI11|"
    "Eigen3::Eigen|Eigen3 3.4|eigen3|"
    "OpenMP::OpenMP_CXX|OpenMP COMPONENTS CXX||${OpenMP_CXX_FLAGS}"
    "OpenMeshCore|OpenMesh CONFIG||-lOpenMeshCore"
    "ZLIB::ZLIB|ZLIB|zlib|"
    "fmt::fmt|fmt|fmt|"
    "nlohmann_json::nlohmann_json|nlohmann_json|nlohmann_json|"
    "yaml-cpp|yaml-cpp|yaml-cpp|")

# What others have to link for the module `name`: modules of ours in `modules`, the rest in `others`.
function(mscomp_links name modules others)
    get_target_property(links mscomp_${name} INTERFACE_LINK_LIBRARIES)
    foreach(link IN LISTS links)
        string(REGEX REPLACE "^\\$<LINK_ONLY:(.*)>$" "\\1" link "${link}")
        string(REGEX REPLACE "^\\$<INSTALL_INTERFACE:(.*)>$" "\\1" link "${link}")
        if(link MATCHES "^\\$<BUILD_INTERFACE:")
            continue()
        elseif(link MATCHES "^mscomp(_|::)(.*)$")
            list(APPEND found_modules ${CMAKE_MATCH_2})
        elseif(link)
            list(APPEND found_others ${link})
        endif()
    endforeach()
    set(${modules} ${found_modules} PARENT_SCOPE)
    set(${others} ${found_others} PARENT_SCOPE)
endfunction()

# All modules that `names` stand on, themselves included, each before what it stands on: the order
# in which a linker wants them.
function(mscomp_in_link_order names result)
    set(order ${${result}})
    foreach(name IN LISTS names)
        if(name IN_LIST order)
            continue()
        endif()
        mscomp_links(${name} modules others)
        mscomp_in_link_order("${modules}" order)
        list(PREPEND order ${name})
    endforeach()
    set(${result} ${order} PARENT_SCOPE)
endfunction()

# The row of mscomp_sources for `target` as a list of its columns; a plain name is for the linker.
function(mscomp_source target result)
    foreach(row IN LISTS mscomp_sources)
        string(REPLACE "|" ";" columns "${row}")
        list(GET columns 0 first)
        if(first STREQUAL target)
            set(${result} "${columns}" PARENT_SCOPE)
            return()
        endif()
    endforeach()
    if(target MATCHES "::" OR TARGET ${target})
        message(FATAL_ERROR "cmake/install.cmake does not know where others find ${target}")
    endif()
    set(${result} "${target};;;-l${target}" PARENT_SCOPE)
endfunction()

# Modules with headers for others, and what these stand on.
get_property(modules GLOBAL PROPERTY MSCOMP_LIBRARIES)
set(libraries "")
foreach(name IN LISTS modules)
    file(GLOB headers "include/mscomp/${name}/*.h" "include/mscomp/*/${name}/*.h")
    if(headers)
        mscomp_in_link_order(${name} libraries)
    endif()
endforeach()
list(SORT libraries)
set(programs acapfeat mscomp)

install(TARGETS ${programs} RUNTIME DESTINATION "${CMAKE_INSTALL_BINDIR}" COMPONENT Runtime)
install(FILES LICENSE DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT Runtime RENAME copyright)

list(TRANSFORM libraries PREPEND mscomp_ OUTPUT_VARIABLE targets)
install(TARGETS ${targets} EXPORT mscomp
        ARCHIVE DESTINATION "${CMAKE_INSTALL_LIBDIR}" COMPONENT Development)
install(DIRECTORY include/mscomp DESTINATION "${CMAKE_INSTALL_INCLUDEDIR}" COMPONENT Development)
install(DIRECTORY docs/examples DESTINATION "${CMAKE_INSTALL_DOCDIR}" COMPONENT Development)

# The package of CMake.
set(package_dir "${CMAKE_INSTALL_LIBDIR}/cmake/mscomp")
set(package_lists "")
foreach(name IN LISTS libraries)
    set(order "")
    mscomp_in_link_order(${name} order)
    set(finds "")
    foreach(module IN LISTS order)
        mscomp_links(${module} modules others)
        foreach(other IN LISTS others)
            mscomp_source(${other} columns)
            list(GET columns 1 find)
            if(find)
                list(APPEND finds "\"${find}\"")
            endif()
        endforeach()
    endforeach()
    list(REMOVE_DUPLICATES finds)
    list(SORT finds)
    list(JOIN finds " " finds)
    string(APPEND package_lists "set(mscomp_needs_${name} ${finds})\n")
endforeach()
configure_package_config_file(cmake/mscompConfig.cmake.in "${PROJECT_BINARY_DIR}/mscompConfig.cmake"
                              INSTALL_DESTINATION "${package_dir}" NO_SET_AND_CHECK_MACRO)
write_basic_package_version_file("${PROJECT_BINARY_DIR}/mscompConfigVersion.cmake"
                                 COMPATIBILITY SameMinorVersion)
install(FILES "${PROJECT_BINARY_DIR}/mscompConfig.cmake"
              "${PROJECT_BINARY_DIR}/mscompConfigVersion.cmake"
        DESTINATION "${package_dir}" COMPONENT Development)
install(EXPORT mscomp NAMESPACE mscomp:: FILE mscompTargets.cmake DESTINATION "${package_dir}"
        COMPONENT Development)

# pkg-config.
set(order "")
mscomp_in_link_order("${libraries}" order)
set(pc_requires "")
set(pc_libs "")
foreach(module IN LISTS order)
    mscomp_links(${module} modules others)
    foreach(other IN LISTS others)
        mscomp_source(${other} columns)
        list(GET columns 2 package)
        list(GET columns 3 words)
        list(APPEND pc_requires ${package})
        list(APPEND pc_libs ${words})
    endforeach()
endforeach()
list(REMOVE_DUPLICATES pc_requires)
list(SORT pc_requires)
list(JOIN pc_requires " " pc_requires)
list(REMOVE_DUPLICATES pc_libs)
list(TRANSFORM order PREPEND "-lmscomp_")
list(JOIN order " " pc_modules)
list(JOIN pc_libs " " pc_libs)
file(RELATIVE_PATH pc_prefix "/${CMAKE_INSTALL_LIBDIR}/pkgconfig" "/")
string(REGEX REPLACE "/$" "" pc_prefix "${pc_prefix}")
configure_file(cmake/mscomp.pc.in "${PROJECT_BINARY_DIR}/mscomp.pc" @ONLY)
install(FILES "${PROJECT_BINARY_DIR}/mscomp.pc" DESTINATION "${CMAKE_INSTALL_LIBDIR}/pkgconfig"
        COMPONENT Development)

# Manual pages and completions, made by the programs themselves.
set(pages "${PROJECT_BINARY_DIR}/command_pages")
foreach(program IN LISTS programs)
    add_custom_command(
        OUTPUT "${pages}/${program}.stamp"
        COMMAND "${CMAKE_COMMAND}" -E rm -rf "${pages}/${program}"
        COMMAND ${program} --command-pages "${pages}/${program}"
        COMMAND "${CMAKE_COMMAND}" -E touch "${pages}/${program}.stamp"
        DEPENDS ${program}
        COMMENT "Manual pages and completions of ${program}")
    list(APPEND stamps "${pages}/${program}.stamp")
    install(DIRECTORY "${pages}/${program}/man/" DESTINATION "${CMAKE_INSTALL_MANDIR}"
            COMPONENT Runtime)
    install(FILES "${pages}/${program}/bash/${program}" COMPONENT Runtime
            DESTINATION "${CMAKE_INSTALL_DATADIR}/bash-completion/completions")
    # Debian's zsh looks for those of packages in another folder than for those of the machine.
    install(CODE "set(mscomp_zsh site-functions)
                  if(CMAKE_INSTALL_PREFIX STREQUAL \"/usr\" AND EXISTS /etc/debian_version)
                      set(mscomp_zsh vendor-completions)
                  endif()" COMPONENT Runtime)
    install(FILES "${pages}/${program}/zsh/_${program}" COMPONENT Runtime
            DESTINATION "${CMAKE_INSTALL_DATADIR}/zsh/\${mscomp_zsh}")
    install(FILES "${pages}/${program}/fish/${program}.fish" COMPONENT Runtime
            DESTINATION "${CMAKE_INSTALL_DATADIR}/fish/vendor_completions.d")
endforeach()
add_custom_target(command_pages ALL DEPENDS ${stamps})

include(cmake/packages.cmake)
