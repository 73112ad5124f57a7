#pragma once

namespace tactile_clay::nodes {

/// Asks this process to shut down, and to exit with `code`; of several calls the largest code counts.
void finish(int code);

/// Whether this process is on its way down; what fails from then on fails for that.
bool shuttingDown();

/// What `main` has to return.
int exitCode();

/// From now on, a node whose name another one takes ends with code 1, which roscpp takes for a good end. Call
/// it once ROS has started.
void failWhenReplaced();

}  // namespace tactile_clay::nodes
