#pragma once

#include <string_view>

namespace hapton {

// proto/hapton.proto and proto/session.proto as a google.protobuf.FileDescriptorSet: with it in a file, other programs can read our
// messages in that file. RT: yes.
std::string_view wire_schema() noexcept;

}  // namespace hapton
