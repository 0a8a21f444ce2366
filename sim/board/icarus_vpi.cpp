// The same bridge as a system function for Icarus Verilog:
// `{rst, rx, rx_valid, rx_data} = $board_clock({tx, tx_valid, tx_data, rx_ready})` takes the outputs
// after a cycle and returns the next inputs.

#include <memory>
#include <string>
#include <vector>

#include <vpi_user.h>

#include "bridge.hpp"

namespace {

std::unique_ptr<board::Bridge> bridge;

// The arguments after the program, which the simulator passes on; `+name=value` is for the Verilog.
board::Options parse_arguments() {
    s_vpi_vlog_info info{};
    vpi_get_vlog_info(&info);
    std::vector<const char*> arguments{"board"};
    bool ours = false;
    for (int i = 0; i < info.argc; ++i) {
        const std::string argument = info.argv[i];
        ours = ours || argument == "--clocks-per-bit";
        if (ours && argument[0] != '+') arguments.push_back(info.argv[i]);
    }
    return board::Options::parse(static_cast<int>(arguments.size()), arguments.data());
}

PLI_INT32 clock(PLI_BYTE8*) {
    if (!bridge) {
        bridge = std::make_unique<board::Bridge>(
            parse_arguments(), board::Pace{.service_cycles = 8, .idle_sleep_ms = 200});
    }
    const vpiHandle call = vpi_handle(vpiSysTfCall, nullptr);
    const vpiHandle arguments = vpi_iterate(vpiArgument, call);
    s_vpi_value value{};
    value.format = vpiIntVal;
    vpi_get_value(vpi_scan(arguments), &value);
    vpi_free_object(arguments);

    // An undefined bit of the chip reads as 0.
    const unsigned pins = static_cast<unsigned>(value.value.integer);
    const auto inputs = bridge->clock({.tx = (pins >> 10 & 1) != 0,
                                       .tx_valid = (pins >> 9 & 1) != 0,
                                       .tx_data = static_cast<std::uint8_t>(pins >> 1),
                                       .rx_ready = (pins & 1) != 0});
    value.value.integer = int{inputs.rst} << 10 | int{inputs.rx} << 9 | int{inputs.rx_valid} << 8 |
                          int{inputs.rx_data};
    vpi_put_value(call, &value, nullptr, vpiNoDelay);
    if (!bridge->running()) {
        bridge.reset();
        vpi_control(vpiFinish, 0);
    }
    return 0;
}

PLI_INT32 width(PLI_BYTE8*) { return 11; }

void register_functions() {
    s_vpi_systf_data function{};
    function.type = vpiSysFunc;
    function.sysfunctype = vpiSizedFunc;
    function.tfname = "$board_clock";
    function.calltf = clock;
    function.sizetf = width;
    vpi_register_systf(&function);
}

}  // namespace

extern "C" {
void (*vlog_startup_routines[])() = {register_functions, nullptr};
}
