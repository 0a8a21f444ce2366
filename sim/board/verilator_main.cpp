// Simulated board around a chip built by Verilator; arguments: see bridge.hpp.

#include <memory>

#include <verilated.h>
#if VM_TRACE
#include <verilated_vcd_c.h>
#endif

#include "Vtop.h"
#include "bridge.hpp"

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
    chip->rst = 1;
    chip->rx = 1;
    chip->eval();
    while (bridge.running()) {
        const auto inputs = bridge.clock(chip->tx);
        chip->rst = inputs.rst;
        chip->rx = inputs.rx;
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
