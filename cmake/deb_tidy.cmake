# What is not for a package, of all that was put together for it; cpack runs this.
set(packed ${CPACK_TEMPORARY_DIRECTORY}${CPACK_PACKAGING_INSTALL_PREFIX})
file(GLOB_RECURSE found LIST_DIRECTORIES true ${packed}/*)
list(FILTER found INCLUDE REGEX "/__pycache__$")  # of who read messages where they were built
if(found)
  file(REMOVE_RECURSE ${found})
endif()
if(CPACK_PACKAGING_INSTALL_PREFIX STREQUAL "/usr")
  # Hooks of a setup.bash that is not there, in a folder that no package has.
  file(REMOVE_RECURSE ${packed}/etc ${packed}/share/tactile_clay/catkin_env_hook)
endif()
# These name the prefix that the build was configured with.
foreach(file lib/pkgconfig/tactile_clay.pc share/tactile_clay/cmake/tactile_clayConfig.cmake)
  file(READ ${packed}/${file} text)
  string(REPLACE "${CPACK_TACTILE_CLAY_PREFIX}" "${CPACK_PACKAGING_INSTALL_PREFIX}" text "${text}")
  file(WRITE ${packed}/${file} "${text}")
endforeach()
