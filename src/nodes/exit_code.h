#pragma once

namespace tactile_clay::nodes {

/// Asks this process to shut down, and to exit with `code`; of several calls the largest code counts.
void finish(int code);

/// What `main` has to return.
int exitCode();

}  // namespace tactile_clay::nodes
