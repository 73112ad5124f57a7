// The program of every node; CMake gives its name.
#include "nodes/node_programs.h"

int main(int argc, char** argv) {
  return tactile_clay::nodes::runNode(TACTILE_CLAY_NODE_NAME, argc, argv);
}
