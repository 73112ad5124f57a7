#pragma once

/// How often the process has called operator new so far, shared libraries and all threads included.
long allocationCount();
