#pragma once

#include <system_error>
#include <thread>
#include <utility>

namespace hapton {

// Prints one line and ends the program with exit code 1: the system starts no more threads. No destructor runs, since other threads may
// hold what it needs. RT: no.
[[noreturn]] void end_without_thread(const std::system_error& rejection);

// Starts a thread; all our threads are started here. If the system denies it (the user's limit of processes, the unit's TasksMax, no
// memory), end_without_thread ends the program, which cannot work without the thread. RT: set-up only, while no force is on the motors.
template <class Run>
std::thread start_thread(Run&& run) {
  try {
    return std::thread(std::forward<Run>(run));
  } catch (const std::system_error& rejection) {
    end_without_thread(rejection);
  }
}

}  // namespace hapton
