# The package as ROS sees it: messages, the catkin package, what is installed.
set(TACTILE_CLAY_ROS_COMPONENTS
  roscpp nodelet pluginlib rosbag_storage message_generation
  std_msgs std_srvs geometry_msgs sensor_msgs visualization_msgs
  diagnostic_updater tf2 tf2_ros tf2_eigen urdf)
find_package(catkin REQUIRED COMPONENTS ${TACTILE_CLAY_ROS_COMPONENTS})

# Several of these packages come without a catkin config on Debian, so the ones below are named one by one.
set(CMAKE_INCLUDE_CURRENT_DIR OFF)

add_message_files(DIRECTORY msg FILES
  AcousticReport.msg ArrayDrive.msg ArrayState.msg ClayStatus.msg FocalPoint.msg FocalPointArray.msg
  RenderingReport.msg RigNumbers.msg TrackedHand.msg TrackedHands.msg)
add_service_files(DIRECTORY srv FILES SculptureFile.srv)
generate_messages(DEPENDENCIES std_msgs geometry_msgs)

# Interfaces for plugins of other packages. In the devel space they are copied to where an install puts them, so
# that `#include <tactile_clay/hand/hand_source.h>` is right in both.
set(TACTILE_CLAY_PUBLIC_HEADERS
  hand/hand_source.h hand/tracked_hand.h device/array_device.h ultrasound/acoustic_field.h ultrasound/acoustics.h
  ultrasound/array_layout.h ultrasound/focal_point.h ultrasound/modulation.h ultrasound/phase_solver.h)
foreach(header ${TACTILE_CLAY_PUBLIC_HEADERS})
  get_filename_component(room ${header} DIRECTORY)
  configure_file(src/${header} ${CATKIN_DEVEL_PREFIX}/include/tactile_clay/${header} COPYONLY)
  install(FILES src/${header} DESTINATION include/tactile_clay/${room})
endforeach()

catkin_package(
  INCLUDE_DIRS ${CATKIN_DEVEL_PREFIX}/include
  CATKIN_DEPENDS message_runtime std_msgs geometry_msgs
  DEPENDS EIGEN3
  CFG_EXTRAS tactile_clay-extras.cmake)

# ROS without rviz, as one target; its headers are not ours to warn about.
add_library(tactile_clay_ros INTERFACE)
target_include_directories(tactile_clay_ros SYSTEM INTERFACE ${CATKIN_DEVEL_PREFIX}/include ${catkin_INCLUDE_DIRS})
target_link_libraries(tactile_clay_ros INTERFACE ${catkin_LIBRARIES})
add_dependencies(tactile_clay_ros ${PROJECT_NAME}_generate_messages_cpp)

# Libraries stand beside each other in the devel and the install space; plugins are found with no LD_LIBRARY_PATH.
set(CMAKE_INSTALL_RPATH "$ORIGIN;$ORIGIN/../../lib")

# tactile_clay_install(TARGET...): libraries to lib/, programs to lib/tactile_clay/ where rosrun looks.
function(tactile_clay_install)
  install(TARGETS ${ARGN}
    LIBRARY DESTINATION ${CATKIN_PACKAGE_LIB_DESTINATION}
    RUNTIME DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
endfunction()

catkin_install_python(PROGRAMS scripts/calibrate_board scripts/describe_rig scripts/fuzz_topics scripts/record_run scripts/replay
  scripts/show_moment scripts/start_when_set
  DESTINATION ${CATKIN_PACKAGE_BIN_DESTINATION})
install(FILES plugins.xml DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(DIRECTORY launch config rviz DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION})
install(DIRECTORY test/bags DESTINATION ${CATKIN_PACKAGE_SHARE_DESTINATION}/test OPTIONAL)
