// Simulated board around a chip built by Verilator; arguments: see bridge.hpp.

#include <memory>

#include <verilated.h>
#if VM_TRACE
#include <verilated_vcd_c.h>
#endif

#include "Vtop.h"
#include "bridge.hpp"

namespace {

// The line of a chip: pins of a UART, or a byte-wide port.
template <typename Chip>
board::FromChip outputs(const Chip& chip) {
    if constexpr (requires { chip.tx; }) {
        return {.tx = chip.tx != 0};
    } else {
        return {.tx_valid = chip.tx_valid != 0,
                .tx_data = chip.tx_data,
                .rx_ready = chip.rx_ready != 0};
    }
}

template <typename Chip>
void set_inputs(Chip& chip, const board::ToChip& inputs) {
    chip.rst = inputs.rst;
    if constexpr (requires { chip.rx; }) {
        chip.rx = inputs.rx;
    } else {
        chip.rx_valid = inputs.rx_valid;
        chip.rx_data = inputs.rx_data;
        chip.tx_ready = 1;
    }
}

}  // namespace

int main(int argc, char** argv) {
    const auto options = board::Options::parse(argc, argv);
    const auto context = std::make_unique<VerilatedContext>();
#if VM_TRACE
    context->traceEverOn(true);
#endif
    const auto chip = std::make_unique<Vtop>(context.get(), "");

#if VM_TRACE
    VerilatedVcdC trace;
    chip->trace(&trace, 99);
    if (!options.trace.empty()) trace.open(options.trace.c_str());
    const auto advance = [&] {
        if (trace.isOpen()) trace.dump(context->time());
        context->timeInc(1);
    };
#else
    const auto advance = [] {};
#endif

    board::Bridge bridge{options, {.service_cycles = 64, .idle_sleep_ms = 20}};
    chip->clk = 0;
    set_inputs(*chip, {.rst = true});
    chip->eval();
    while (bridge.running()) {
        set_inputs(*chip, bridge.clock(outputs(*chip)));
        chip->clk = 1;
        chip->eval();
        advance();
        chip->clk = 0;
        chip->eval();
        advance();
    }
    chip->final();
    return 0;
}
