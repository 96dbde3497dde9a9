#include "tests/standins/haply_service.h"

#include <fmt/core.h>
#include <sys/socket.h>

#include <boost/asio/io_context.hpp>
#include <boost/asio/ip/tcp.hpp>
#include <boost/beast/core/buffers_to_string.hpp>
#include <boost/beast/core/flat_buffer.hpp>
#include <boost/beast/http.hpp>
#include <boost/beast/websocket/stream.hpp>
#include <cerrno>
#include <chrono>
#include <cmath>
#include <nlohmann/json.hpp>
#include <utility>

namespace hapton {
namespace {

namespace asio = boost::asio;
namespace beast = boost::beast;
using asio::ip::tcp;
using boost::system::error_code;

constexpr std::string_view kJunk = R"({"inverse3": [{"device_id": 7, "state")";

}  // namespace

struct HaplyService::Listening {
  asio::io_context context{1};
  tcp::acceptor acceptor{context};
};

HaplyService::HaplyService(std::uint16_t port, std::string initial_version)
    : version(std::move(initial_version)), listening_(std::make_unique<Listening>()) {
  tcp::acceptor& acceptor = listening_->acceptor;
  acceptor.open(tcp::v4());
  acceptor.set_option(asio::socket_base::reuse_address(true));
  acceptor.bind({asio::ip::address_v4::loopback(), port});
  acceptor.listen();
  acceptor.non_blocking(true);
  port_ = acceptor.local_endpoint().port();
  thread_ = std::thread([this] { run(); });
}

HaplyService::~HaplyService() {
  ends_ = true;
  thread_.join();
}

void HaplyService::run() {
  while (!ends_) {
    tcp::socket socket(listening_->context);
    error_code error;
    listening_->acceptor.accept(socket, error);
    if (error) {
      std::this_thread::sleep_for(std::chrono::milliseconds(1));
      continue;
    }
    socket.non_blocking(false);
    serve(&socket);
  }
}

// Waits for a message. False: the client has disconnected, or the service is being destroyed.
bool HaplyService::await_message(int socket) {
  while (!ends_) {
    char first = 0;
    const ssize_t received = ::recv(socket, &first, 1, MSG_PEEK | MSG_DONTWAIT);
    if (received == 0 || (received < 0 && errno != EAGAIN)) return false;
    if (received > 0) return true;
    std::this_thread::sleep_for(std::chrono::microseconds(200));
  }
  return false;
}

void HaplyService::serve(void* accepted) {
  auto& socket = *static_cast<tcp::socket*>(accepted);
  error_code error;
  socket.set_option(tcp::no_delay(true), error);
  beast::flat_buffer request_buffer;
  beast::http::request<beast::http::string_body> request;
  beast::http::read(socket, request_buffer, request, error);
  if (error) return;
  if (!beast::websocket::is_upgrade(request)) {
    const bool has_version_page = request.target() == "/version" && !version.empty();
    beast::http::response<beast::http::string_body> response{has_version_page ? beast::http::status::ok : beast::http::status::not_found,
                                                             11};
    response.body() = fmt::format(R"({{"project_name":"haply-inverse-service","project_version":"{}"}})", version);
    response.prepare_payload();
    beast::http::write(socket, response, error);
    return;
  }
  beast::websocket::stream<tcp::socket&> stream(socket);
  stream.accept(request, error);
  if (error) return;
  ++connections;
  if (hangs_up) return;
  stream.text(true);
  stream.write(asio::buffer(sends_junk ? std::string(kJunk) : state(true)), error);
  for (bool is_first = true; !error && !ends_; is_first = false) {
    if (!await_message(socket.native_handle())) return;
    beast::flat_buffer buffer;
    stream.read(buffer, error);
    closed_in_order += error == beast::websocket::error::closed ? 1 : 0;
    if (error) return;
    receive(beast::buffers_to_string(buffer.cdata()), is_first);
    if (is_silent) continue;
    stream.write(asio::buffer(sends_junk ? std::string(kJunk) : state(false)), error);
  }
}

std::string HaplyService::state(bool with_config) const {
  std::string arms;
  const bool is_absent = absent_states > 0 && absent_states-- > 0;
  if (is_plugged && !is_absent) {
    const std::string config = with_config
                                   ? fmt::format(R"("config":{{"type":"{}","extended_firmware_version":"7.4.0","handedness":"right"{}}},)",
                                                 type, mount.empty() ? "" : ",\"mount\":" + mount)
                                   : "";
    std::string transform_member = with_config && !transform.empty() ? ",\"transform\":" + transform : "";
    if (is_scaled) transform_member = R"(,"transform":{"scale":{"x":2,"y":2,"z":2}})";
    if (!with_config && !is_scaled && was_scaled_.exchange(false)) transform_member = R"(,"transform":{"scale":{"x":1,"y":1,"z":1}})";
    if (is_scaled) was_scaled_ = true;
    arms = fmt::format(R"({{"device_id":"049D",{}"state":{{"cursor_position":{{"x":{},"y":{},"z":{}}},)"
                       R"("cursor_velocity":{{"x":0,"y":0,"z":0}}{}}},"status":{{"calibrated":{}}}}})",
                       config, position_m[0].load(), position_m[1].load(), position_m[2].load(), transform_member,
                       is_calibrated ? "true" : "false");
  }
  std::string grips;
  if (has_grip) {
    const double sqrt_half = std::sqrt(0.5);
    grips = fmt::format(
        R"({{"device_id":"61","state":{{"orientation":{{"w":{0},"x":0,"y":0,"z":{0}}},"buttons":{{"a":{1},"b":{2},"c":false}}}}}})",
        sqrt_half, (buttons & 1) != 0, (buttons & 2) != 0);
  }
  return fmt::format(R"({{"session_id":7,"inverse3":[{}],"wireless_verse_grip":[{}]}})", arms, grips);
}

void HaplyService::receive(const std::string& message, bool is_first) {
  ++messages;
  if (is_first) {
    const std::lock_guard lock(mutex_);
    first_message_ = message;
  }
  const auto json = nlohmann::json::parse(message);
  const auto& vector = json.at("inverse3").at(0).at("commands").at("set_cursor_force").at("vector");
  double norm2 = 0.0;
  for (std::size_t axis = 0; axis < 3; ++axis) {
    constexpr std::array<const char*, 3> kAxes = {"x", "y", "z"};
    force_n[axis] = vector.at(kAxes[axis]).get<double>();
    norm2 += force_n[axis] * force_n[axis];
  }
  largest_force_n = std::max<double>(largest_force_n, std::sqrt(norm2));
}

}  // namespace hapton
