#include "link/address_endpoint.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <boost/asio/ip/udp.hpp>
#include <cstring>

namespace hapton {
namespace {

using Udp = boost::asio::ip::udp::endpoint;

TEST(AddressConversion, LosesNothingEitherWay) {
  for (const char* text : {"127.0.0.1:4950", "255.1.2.3:65535", "0.0.0.0:0", "[::1]:4950", "[2001:db8::7]:1", "[::]:7"}) {
    const Address address = *parse_address(text);
    EXPECT_EQ(from_socket_address(to_socket_address(address)), address) << text;
    EXPECT_EQ(from_endpoint(to_endpoint<Udp>(address)), address) << text;
    EXPECT_EQ(to_asio(address).is_v4(), is_v4(address)) << text;
    EXPECT_EQ(to_socket_address(address).get()->sa_family, address_family(address)) << text;
  }
}

TEST(AddressConversion, ASocketOfIpv6ReachesEveryAddress) {
  for (const char* text : {"127.0.0.1:4950", "255.1.2.3:65535", "[2001:db8::7]:1"}) {
    const Address address = *parse_address(text);
    const SocketAddress v6 = to_v6_socket_address(address);
    EXPECT_EQ(v6.get()->sa_family, AF_INET6) << text;
    EXPECT_EQ(v6.size, sizeof(sockaddr_in6)) << text;
    EXPECT_EQ(from_socket_address(v6), address) << text;
  }
}

TEST(AddressConversion, SystemAndAsioAgree) {
  const Address address = *parse_address("[2001:db8::1:2]:4951");
  const Udp endpoint = to_endpoint<Udp>(address);
  const SocketAddress system = to_socket_address(address);
  ASSERT_EQ(system.size, endpoint.size());
  EXPECT_EQ(std::memcmp(&system.storage, endpoint.data(), system.size), 0);
}

TEST(AddressConversion, ReportsWhereASocketIsBound) {
  const int socket = ::socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  ASSERT_GE(socket, 0);
  const SocketAddress any = to_socket_address(*parse_address("127.0.0.1:0"));
  ASSERT_EQ(::bind(socket, any.get(), any.size), 0);
  const Address bound = local_address(socket);
  ::close(socket);
  EXPECT_TRUE(is_loopback(bound));
  EXPECT_NE(bound.port, 0);
  EXPECT_EQ(local_address(-1), Address{});
}

}  // namespace
}  // namespace hapton
