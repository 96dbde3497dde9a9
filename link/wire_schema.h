#pragma once

#include <string_view>

namespace hapton {

// proto/hapton.proto and proto/session.proto as a google.protobuf.FileDescriptorSet: what a file needs for other programs to read our
// messages in it. RT: yes.
std::string_view wire_schema() noexcept;

}  // namespace hapton
