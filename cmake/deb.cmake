# `cpack -G DEB` in a build folder: a package for this distribution, beside the ROS that it was built with.
find_program(GZIP gzip)
if(EXISTS /opt/ros/noetic)
  set(CPACK_DEBIAN_PACKAGE_NAME ros-noetic-tactile-clay)
  set(CPACK_PACKAGING_INSTALL_PREFIX /opt/ros/noetic)
  set(run_dependencies ros-noetic-roslaunch ros-noetic-rosbag ros-noetic-rospy ros-noetic-rosbash ros-noetic-rostopic
    ros-noetic-rosservice ros-noetic-nodelet ros-noetic-message-runtime ros-noetic-tf2-msgs
    ros-noetic-visualization-msgs ros-noetic-diagnostic-msgs ros-noetic-dynamic-reconfigure
    ros-noetic-robot-state-publisher ros-noetic-rviz)
else()
  set(CPACK_DEBIAN_PACKAGE_NAME tactile-clay)
  set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
  set(run_dependencies python3-roslaunch python3-rosbag python3-rospy rosbash python3-rostopic python3-rosservice
    libnodeletlib-tools rosout ros-message-runtime python3-tf2-msgs python3-std-msgs python3-std-srvs
    python3-geometry-msgs python3-sensor-msgs python3-visualization-msgs python3-diagnostic-msgs
    python3-dynamic-reconfigure ros-robot-state-publisher rviz)
endif()
# What programs and scripts call; libraries are found by what is linked (dpkg-shlibdeps).
list(APPEND run_dependencies python3 python3-yaml python3-rospkg util-linux)
list(JOIN run_dependencies ", " CPACK_DEBIAN_PACKAGE_DEPENDS)
set(CPACK_DEBIAN_PACKAGE_RECOMMENDS python3-matplotlib)  # of plot_accuracy
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS ON)
set(CPACK_DEBIAN_PACKAGE_SHLIBDEPS_PRIVATE_DIRS ${CATKIN_DEVEL_PREFIX}/lib)  # our own
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_PACKAGE_CONTACT "tactile_clay authors <tactile_clay@users.noreply.github.com>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "virtual clay for bare hands, felt through an ultrasound array")
set(CPACK_DEBIAN_PACKAGE_DESCRIPTION "Hand tracking, a particle-based clay, contact pressure on the skin, rendering by
focal points and the drivers of ultrasound arrays, as nodes of ROS 1 with their tools.")
set(CPACK_STRIP_FILES ON)
set(CPACK_INSTALL_DEFAULT_DIRECTORY_PERMISSIONS
  OWNER_READ OWNER_WRITE OWNER_EXECUTE GROUP_READ GROUP_EXECUTE WORLD_READ WORLD_EXECUTE)
set(CPACK_TACTILE_CLAY_PREFIX ${CMAKE_INSTALL_PREFIX})
set(CPACK_PRE_BUILD_SCRIPTS ${PROJECT_SOURCE_DIR}/cmake/deb_tidy.cmake)  # from CMake 3.19 on
# Without the component `environment`: setup.bash and its like are those of ROS there.
set(CPACK_INSTALL_CMAKE_PROJECTS "${CMAKE_BINARY_DIR};${PROJECT_NAME};Unspecified;/")

# What Debian asks of each package.
install(FILES LICENSE DESTINATION share/doc/${CPACK_DEBIAN_PACKAGE_NAME} RENAME copyright)
if(GZIP)
  #catkin_lint: ignore MISSING_FILE
  execute_process(COMMAND ${GZIP} -9nc ${PROJECT_SOURCE_DIR}/CHANGELOG.rst
    OUTPUT_FILE ${CMAKE_BINARY_DIR}/changelog.gz)
  install(FILES ${CMAKE_BINARY_DIR}/changelog.gz DESTINATION share/doc/${CPACK_DEBIAN_PACKAGE_NAME})
  #catkin_lint: report MISSING_FILE
endif()
include(CPack)
