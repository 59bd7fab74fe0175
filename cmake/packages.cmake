# Packages, by `cpack -G DEB` (mscomp, libmscomp-dev) and `cpack -G TGZ` (everything in one).
set(CPACK_PACKAGE_NAME mscomp)
set(CPACK_PACKAGE_VENDOR "the mscomp authors")
set(CPACK_PACKAGE_CONTACT "the mscomp authors <mscomp@localhost>" CACHE STRING
    "Who made a Debian package: name and address")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "${PROJECT_DESCRIPTION}")
set(CPACK_RESOURCE_FILE_LICENSE "${PROJECT_SOURCE_DIR}/LICENSE")
set(CPACK_STRIP_FILES ON)
set(CPACK_VERBATIM_VARIABLES ON)
set(CPACK_GENERATOR "DEB;TGZ")

set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_NAME mscomp)
set(CPACK_DEBIAN_RUNTIME_PACKAGE_SHLIBDEPS ON)
set(CPACK_COMPONENT_RUNTIME_DESCRIPTION
    "The programs acapfeat and mscomp
They turn meshes of one connectivity into ACAP features, learn localised
deformation components of them at several scales, measure and mix them.")

set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_NAME libmscomp-dev)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SECTION libdevel)
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS
    "libceres-dev, libeigen3-dev, libfmt-dev, libopenmesh-dev, libsuitesparse-dev, libyaml-cpp-dev, nlohmann-json3-dev, zlib1g-dev")
if(MSCOMP_HAS_HDF5)
    string(APPEND CPACK_DEBIAN_DEVELOPMENT_PACKAGE_DEPENDS ", libhdf5-dev")
endif()
set(CPACK_DEBIAN_DEVELOPMENT_PACKAGE_SUGGESTS "cmake, pkgconf")
set(CPACK_COMPONENT_DEVELOPMENT_DESCRIPTION
    "Static libraries and headers of mscomp
For programs of one's own: reading and checking meshes, ACAP features and
back, training, components; found by CMake and by pkg-config.")

include(CPack)
