// uart_line CLOCKS_PER_BIT HEX: prints the levels of a line that carries the bytes and 3 idle cycles,
// the bytes read back from it, and the errors for a short start bit and a missing stop bit.

#include <cstdio>
#include <cstdlib>
#include <string>
#include <vector>

#include "uart.hpp"

namespace {

using Event = board::UartSampler::Event;

const char* first_event(unsigned clocks_per_bit, unsigned low_cycles) {
    board::UartSampler sampler{clocks_per_bit};
    for (unsigned cycle = 0; cycle < 20 * clocks_per_bit; ++cycle) {
        switch (sampler.clock(cycle >= low_cycles)) {
            case Event::kNothing: break;
            case Event::kByte: return "byte";
            case Event::kGlitch: return "glitch";
            case Event::kFramingError: return "framing";
        }
    }
    return "nothing";
}

}  // namespace

int main(int argc, char** argv) {
    if (argc != 3) return 2;
    const auto clocks_per_bit = static_cast<unsigned>(std::atoi(argv[1]));
    const std::string hex = argv[2];
    std::vector<std::uint8_t> bytes;
    for (std::size_t i = 0; i < hex.size(); i += 2) {
        bytes.push_back(static_cast<std::uint8_t>(std::stoul(hex.substr(i, 2), nullptr, 16)));
    }

    board::UartDriver driver{clocks_per_bit};
    board::UartSampler sampler{clocks_per_bit};
    driver.push(bytes.data(), bytes.size());
    std::string levels;
    std::string read_back;
    for (unsigned cycle = 0; cycle < bytes.size() * 10 * clocks_per_bit + 3; ++cycle) {
        const bool level = driver.clock();
        levels += level ? '1' : '0';
        if (sampler.clock(level) == Event::kByte) {
            char text[3];
            std::snprintf(text, sizeof text, "%02x", sampler.byte());
            read_back += text;
        }
    }
    std::printf("%s\n%s\n", levels.c_str(), read_back.c_str());
    std::printf("%s\n", first_event(clocks_per_bit, clocks_per_bit / 2));
    std::printf("%s\n", first_event(clocks_per_bit, 10 * clocks_per_bit));
    return driver.idle() && sampler.idle() ? 0 : 1;
}
