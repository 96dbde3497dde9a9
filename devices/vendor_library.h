#pragma once

#include <span>
#include <string>
#include <string_view>
#include <type_traits>
#include <vector>

#include "core/base/result.h"

namespace hapton {

// A vendor's library that we can use when it is there, by names of our own declarations: nothing of it is needed to build.
struct KnownVendorLibrary {
  std::string_view name;                          // for people: "OpenHaptics"
  std::string_view device;                        // as in --device
  std::span<const std::string_view> file_names;   // in the order they are tried
  std::string_view devices;                       // what it drives
  std::string_view source;                        // where a person gets it
  std::span<const std::string_view> environment;  // variables that it reads, or that its users set
};

// All of them. RT: set-up only.
std::span<const KnownVendorLibrary> known_vendor_libraries();
extern const KnownVendorLibrary kOpenHaptics;
extern const KnownVendorLibrary kForceDimension;

// One name that was tried and did not load.
struct FailedLoad {
  std::string file;
  std::string error;  // the loader's words, unchanged
  std::string hint;   // what a person can do about it, one line; never empty
};

// What the loader's words mean for `file`: which dependency is missing, and so on.
std::string hint_for_load_error(std::string_view file, std::string_view error);

// A library of a vendor, loaded at run time. It stays loaded until the process ends, whatever becomes of this object: such libraries leave
// threads behind.
// RT: set-up only. Threads: any.
class VendorLibrary {
 public:
  // Loads the first of the library's names that can be; with `file` that one alone (a path, or a name for the loader to look up).
  // Error: one line with the loader's own words for every name, and the hint that helps most.
  static Result<VendorLibrary> open(const KnownVendorLibrary& known, const std::string& file = "");

  // The same, and what went wrong on the way; not loaded: file() is empty.
  static VendorLibrary try_open(const KnownVendorLibrary& known, const std::string& file, std::vector<FailedLoad>& failures);

  // Where it was loaded from.
  const std::string& file() const { return file_; }

  // Function: the type of the function, `find<int(double)>("f")`. Null when the library has no such symbol.
  template <class Function>
  Function* find(const char* symbol) const noexcept {
    static_assert(std::is_function_v<Function>);
    return reinterpret_cast<Function*>(address_of(symbol));
  }

  // Fills `into` with the function of that name, or notes the name among the missing.
  template <class Function>
  void require(const char* symbol, Function*& into, std::vector<std::string_view>& missing) const {
    into = find<Function>(symbol);
    if (into == nullptr) missing.emplace_back(symbol);
  }

 private:
  void* address_of(const char* symbol) const noexcept;

  void* handle_ = nullptr;
  std::string file_;
};

// "libHD.so has no hdFoo, hdBar: ..." Pre: missing is not empty.
Error missing_symbols(const VendorLibrary& library, std::span<const std::string_view> missing);

}  // namespace hapton
