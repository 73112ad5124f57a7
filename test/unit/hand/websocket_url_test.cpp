#include <gtest/gtest.h>

#include <stdexcept>
#include <string>

#include "hand/leap_websocket.h"

namespace tactile_clay::hand::websocket_url_test {
namespace {

TEST(WebsocketUrl, IsReadWithWhatIsMissingFilledIn) {
  EXPECT_EQ(parseWebsocketUrl("").text(), "ws://localhost:6437/v6.json");
  EXPECT_EQ(parseWebsocketUrl("tracker").text(), "ws://tracker:6437/v6.json");
  EXPECT_EQ(parseWebsocketUrl("ws://10.0.0.2:80").text(), "ws://10.0.0.2:80/v6.json");
  EXPECT_EQ(parseWebsocketUrl("ws://[::1]:6437/v6.json").text(), "ws://[::1]:6437/v6.json");
  EXPECT_EQ(parseWebsocketUrl("lab-pc.local/v7.json").text(), "ws://lab-pc.local:6437/v7.json");
}

TEST(WebsocketUrl, SaysWhatIsExpected) {
  for (const char* bad : {"http://localhost", "wss://localhost:6437", "ws://", "ws://a:b", "ws://a:70000",
                          "ws://a:0", "ws://a b", "a/b c", "\n"}) {
    try {
      parseWebsocketUrl(bad);
      ADD_FAILURE() << "'" << bad << "' is taken for a url";
    } catch (const std::runtime_error& error) {
      EXPECT_NE(std::string(error.what()).find("expected ws://HOST[:PORT][/PATH]"), std::string::npos);
    }
  }
}

TEST(WebsocketUrl, AnEndlessOneIsRefused) {
  try {
    parseWebsocketUrl("ws://a/" + std::string(100'000, 'b'));
    ADD_FAILURE() << "it is taken for a url";
  } catch (const std::runtime_error& error) {
    EXPECT_NE(std::string(error.what()).find("100007 bytes, expected at most 2048"), std::string::npos);
    EXPECT_LT(std::string(error.what()).size(), 200U);
  }
}

}  // namespace
}  // namespace tactile_clay::hand::websocket_url_test
