#pragma once

#include <boost/system/system_error.hpp>
#include <memory>
#include <utility>

#include "core/base/result.h"

namespace hapton {

// Like make_unique, for a class that owns an asio::io_context, whose constructor throws if the system has no descriptor left for it (epoll,
// timer, event). Error: one line. RT: set-up only.
template <class Owner, class... Arguments>
Result<std::unique_ptr<Owner>> make_with_context(Arguments&&... arguments) {
  try {
    return std::make_unique<Owner>(std::forward<Arguments>(arguments)...);
  } catch (const boost::system::system_error& error) {
    return fail("no file descriptor left for the network ({}); allow more with: ulimit -n 1024", error.code().message());
  }
}

}  // namespace hapton
