#include "lcm_io/host_checks.h"

#include <gmock/gmock.h>

namespace rubble::lcm_io {
namespace {

using testing::AllOf;
using testing::HasSubstr;
using testing::IsEmpty;

HostCheck find(const std::string& url, const std::string& name) {
  for (const HostCheck& check : checkHost(url)) {
    if (check.name == name) {
      return check;
    }
  }
  ADD_FAILURE() << "no check named " << name;
  return {};
}

TEST(HostChecks, UrlsWithoutANetworkNeedNothing) {
  EXPECT_THAT(checkHost("memq://"), IsEmpty());
  EXPECT_THAT(checkHost("file://a.lcm?speed=0"), IsEmpty());
}

TEST(HostChecks, AUrlWithoutABufferSizeIsNamedWithItsFix) {
  for (const char* url :
       {"udpm://", "udpm://239.255.76.67:7667?ttl=0", "udpm://?recv_buf_size=", "udpm://?recv_buf_size=x"}) {
    const HostCheck check = find(url, "receive buffer");
    EXPECT_FALSE(check.ok) << url;
    EXPECT_FALSE(check.fatal);
    EXPECT_THAT(check.text, HasSubstr("fix: add recv_buf_size=4194304 to --lcm-url"));
  }
}

TEST(HostChecks, ABufferTheKernelDoesNotGrantIsNamedWithItsFix) {
  const HostCheck check = find("udpm://239.255.76.67:7667?recv_buf_size=2147483647", "receive buffer");
  EXPECT_FALSE(check.ok);
  EXPECT_THAT(check.text,
              AllOf(HasSubstr("of 2147483647 bytes"), HasSubstr("fix: sysctl -w net.core.rmem_max=8388608")));
}

TEST(HostChecks, ASmallBufferIsGranted) {
  const HostCheck check = find("udpm://239.255.76.67:7667?ttl=0&recv_buf_size=4096&x=1", "receive buffer");
  EXPECT_TRUE(check.ok);
  EXPECT_EQ(check.text, "the kernel grants 4096 bytes");
}

TEST(HostChecks, TheGroupMustBeAnAddress) {
  const HostCheck check = find("udpm://robot:7667", "multicast route");
  EXPECT_FALSE(check.ok);
  EXPECT_TRUE(check.fatal);
  EXPECT_EQ(check.text, "robot is no IPv4 address");
}

}  // namespace
}  // namespace rubble::lcm_io
