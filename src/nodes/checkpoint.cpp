#include "nodes/checkpoint.h"

#include <ros/console.h>

#include <exception>
#include <utility>

#include "clay/sculpture_file.h"

namespace tactile_clay::nodes {

Checkpoint::Checkpoint(std::string file) : file_(std::move(file)), thread_([this] { run(); }) {}

Checkpoint::~Checkpoint() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    ending_ = true;
  }
  came_.notify_all();
  thread_.join();
}

void Checkpoint::keep(clay::Sculpture clay) {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    waiting_ = std::move(clay);
  }
  came_.notify_all();
}

void Checkpoint::run() {
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    came_.wait(lock, [this] { return ending_ || waiting_; });
    if (ending_) return;
    const clay::Sculpture clay = std::move(*waiting_);
    waiting_.reset();
    lock.unlock();
    try {
      clay::save(clay, file_, files::Existing::replace);
    } catch (const std::exception& error) {
      ROS_WARN_THROTTLE(60.0, "no checkpoint of the clay was saved: %s", error.what());
    }
    lock.lock();
  }
}

}  // namespace tactile_clay::nodes
