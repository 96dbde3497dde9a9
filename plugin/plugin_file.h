#pragma once

#include <cstdint>
#include <initializer_list>
#include <string>
#include <vector>

#include "core/base/result.h"
#include "plugin/hapton_plugin.h"
#include "plugin/plugin_choice.h"

namespace hapton {

// A shared library with a plug-in. It stays loaded until the process ends: its threads, if it has any, may outlive this object. RT: set-up
// only. Threads: any.
class PluginFile {
 public:
  // Error: one line: no such file, not a shared library, one for another processor, one that has changed since this process loaded it, or
  // what the loader says.
  static Result<PluginFile> open(const PluginChoice& choice);

  // The constants that it exports, of this version and size, with every function that is not optional and bounds in range. Error: one line
  // that says what is missing, or what to recompile.
  Result<const hapton_effect_api*> find_effect() const;
  Result<const hapton_method_api*> find_method() const;
  Result<const hapton_device_api*> find_device() const;

  const PluginChoice& choice() const { return choice_; }
  const std::string& path() const { return choice_.file; }
  // Of the file's bytes and the parameters. Not against forgery.
  std::uint64_t hash() const { return hash_; }

 private:
  explicit PluginFile(PluginChoice choice) : choice_(std::move(choice)) {}
  Result<const std::uint32_t*> find(const char* symbol, std::initializer_list<std::size_t> sizes) const;
  Error explain_missing(const char* symbol) const;

  PluginChoice choice_;
  void* handle_ = nullptr;
  std::uint64_t hash_ = 0;
};

// What create and open get, and what they report in `why`. It must outlive the call only. RT: set-up only.
class PluginRequest {
 public:
  explicit PluginRequest(const PluginChoice& choice);
  PluginRequest(const PluginRequest&) = delete;
  PluginRequest& operator=(const PluginRequest&) = delete;

  const hapton_request* get() const { return &request_; }
  // "FILE: WHAT rejected it: why", in one line.
  Error rejection(const std::string& name) const;

 private:
  const PluginChoice& choice_;
  std::vector<hapton_parameter> parameters_;
  std::vector<char> why_;
  hapton_request request_ = {};
};

// Runs code of a plug-in; false if it threw a C++ exception. RT: as the code is.
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
