#pragma once

#include <functional>
#include <string>

namespace hapton::doctor {

// What a question to foreign code came to.
struct ChildAnswer {
  std::string text;
  std::string failure;  // it ended the process, or took too long: how; empty: it was answered
};

// Asks in a process of its own, so that a library or driver that crashes, hangs or prints does not take the doctor with it.
// Pre: the caller has no other threads. RT: no.
ChildAnswer run_in_child(const std::function<std::string()>& question, double at_most_s);

}  // namespace hapton::doctor
