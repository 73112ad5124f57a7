// The program of every node; CMake names the class and its header.
#include "nodes/run_node.h"
#include TACTILE_CLAY_NODE_HEADER

int main(int argc, char** argv) {
  return tactile_clay::nodes::runNode<tactile_clay::nodes::TACTILE_CLAY_NODE_CLASS>(argc, argv,
                                                                                    TACTILE_CLAY_NODE_NAME);
}
