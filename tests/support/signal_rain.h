#pragma once

#include <signal.h>
#include <sys/time.h>

namespace hapton {

// A signal each millisecond, whose handler does nothing: it interrupts every wait of this process that can be interrupted.
class SignalRain {
 public:
  SignalRain() {
    struct sigaction ignoring = {};
    ignoring.sa_handler = [](int) {};
    ::sigaction(SIGALRM, &ignoring, &before_);
    const itimerval each_ms = {{0, 1000}, {0, 1000}};
    ::setitimer(ITIMER_REAL, &each_ms, nullptr);
  }
  ~SignalRain() {
    const itimerval never = {};
    ::setitimer(ITIMER_REAL, &never, nullptr);
    ::sigaction(SIGALRM, &before_, nullptr);
  }
  SignalRain(const SignalRain&) = delete;
  SignalRain& operator=(const SignalRain&) = delete;

 private:
  struct sigaction before_ = {};
};

}  // namespace hapton
