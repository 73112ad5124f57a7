# rviz asks for a package media_export, which Debian does not have, and complains of it: here is an empty one.
_tactile_clay_packages="$CATKIN_ENV_HOOK_WORKSPACE/share/tactile_clay/rviz/packages"
case ":$ROS_PACKAGE_PATH:" in
  *":$_tactile_clay_packages:"*) ;;
  *) export ROS_PACKAGE_PATH="$ROS_PACKAGE_PATH:$_tactile_clay_packages" ;;
esac
unset _tactile_clay_packages
