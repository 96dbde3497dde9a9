#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "plugin/hapton_plugin.h"
#include "plugin/plugin_choice.h"

namespace hapton {

// A shared library with a plug-in. The library stays loaded until the process ends, because its threads, if it has any, may outlive this
// object. RT: set-up only. Threads: any.
class PluginFile {
 public:
  // Error: one line: no such file, not a shared library, one for another processor, one that has changed since this process loaded it, or
  // what the loader says.
  static Result<PluginFile> open(const PluginChoice& choice);

  // The exported constant of that kind: of this version and size, with every function that is not optional and, of effects and methods,
  // bounds in range. Error: one line that says what is missing, what is out of range, or what to recompile.
  Result<const hapton_effect_api*> find_effect() const;
  Result<const hapton_method_api*> find_method() const;
  Result<const hapton_device_api*> find_device() const;

  const PluginChoice& choice() const { return choice_; }
  const std::string& path() const { return choice_.file; }
  // A hash of the file's bytes and the parameters. It does not protect against forgery.
  std::uint64_t hash() const { return hash_; }

 private:
  explicit PluginFile(PluginChoice choice) : choice_(std::move(choice)) {}
  Result<const std::uint32_t*> find(const char* symbol, std::initializer_list<std::size_t> sizes) const;
  Error explain_missing(const char* symbol) const;

  PluginChoice choice_;
  void* handle_ = nullptr;
  std::uint64_t hash_ = 0;
};

// The hapton_request for create or open, with the text that these write into `why`. It need only outlive that call. RT: set-up only.
class PluginRequest {
 public:
  explicit PluginRequest(const PluginChoice& choice);
  PluginRequest(const PluginRequest&) = delete;
  PluginRequest& operator=(const PluginRequest&) = delete;

  const hapton_request* get() const { return &request_; }
  // One line: "FILE:KEY=VALUE: NAME does not start: why".
  Error rejection(const std::string& name) const;

 private:
  const PluginChoice& choice_;
  std::vector<hapton_parameter> parameters_;
  std::vector<char> why_;
  hapton_request request_ = {};
};

// Runs code of a plug-in; false if it threw a C++ exception. RT: if that code is.
template <class Call>
bool call_plugin(Call&& call) noexcept {
  try {
    call();
  } catch (...) {
    return false;
  }
  return true;
}

// A plug-in's name for logs and recordings: at most 24 letters, digits, "_", "-" and "."; others become "_".
std::string clean_plugin_name(const char* name);

}  // namespace hapton
