#pragma once

#include <system_error>
#include <thread>
#include <utility>

namespace hapton {

// One line, and the end of the program with exit code 1: the system starts no more threads. Nothing is tidied up: other threads may hold
// what that would need. RT: no.
[[noreturn]] void end_without_thread(const std::system_error& rejection);

// A thread that runs this. Every thread of ours is started here. A system that refuses it (the user's limit of processes, the unit's
// TasksMax, no memory) ends the program by end_without_thread: it could not do what it is for. RT: set-up only, while no force is out.
template <class Run>
std::thread start_thread(Run&& run) {
  try {
    return std::thread(std::forward<Run>(run));
  } catch (const std::system_error& rejection) {
    end_without_thread(rejection);
  }
}

}  // namespace hapton
