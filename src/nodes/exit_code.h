#pragma once

namespace tactile_clay::nodes {

/// Asks this process to shut down, and to exit with `code`. If it is called several times, the largest code
/// counts.
void finish(int code);

/// Whether this process is shutting down. Failures after that moment are a consequence of it, and no errors.
bool shuttingDown();

/// The exit code that `main` has to return.
int exitCode();

/// From now on, a node that is shut down because another node took its name exits with 1. With roscpp alone
/// it would exit with 0. To be called once ROS has started.
void failWhenReplaced();

}  // namespace tactile_clay::nodes
