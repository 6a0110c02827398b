//! The device: memory, kernels, events.

use crate::scene::{Columns, SHEET, Scene};
use crumple_device_kernels::{COLUMNS, Mesh, STEPS, Step};
use cudarc::driver::{DriverError, result, sys};
use std::error::Error;
use std::ffi::{CString, c_void};
use std::ptr::null_mut;

/// Kernels of the elements: with direct calls of the law, and with calls through a table.
pub const DIRECT: &str = "elements_direct";
pub const TABLE: &str = "elements_table";

/// A GPU with its kernels.
pub struct Gpu {
    module: sys::CUmodule,
    device: sys::CUdevice,
    /// The shells, which only the device can read.
    shell: sys::CUdeviceptr,
}

/// Milliseconds per step of both kernels alone, and of both together.
pub struct Times {
    pub elements: f64,
    pub nodes: f64,
    pub step: f64,
}

/// A scene in the memory of the device.
pub struct OnDevice<'a> {
    gpu: &'a Gpu,
    host: Columns,
    buffers: Vec<sys::CUdeviceptr>,
    mesh: sys::CUdeviceptr,
    steps: sys::CUdeviceptr,
    counts: [usize; 2],
    done: u32,
}

/// Memory of a thread for its calls [bytes].
const STACK: usize = 32 << 10;

/// Memory for the parameters of the shells [bytes].
const SHELL_BYTES: usize = 4096;

impl Gpu {
    /// Loads the kernels and builds the shells.
    pub fn new(path: &str) -> Result<Self, Box<dyn Error>> {
        // PTX is text with a zero at its end; a zero after a binary does no harm.
        let mut image = std::fs::read(path)?;
        image.push(0);
        // SAFETY: it loads a library and looks at nothing in it.
        if !unsafe { sys::is_culib_present() } {
            return Err(
                "there is no NVIDIA driver here (libcuda): run on a machine with one".into()
            );
        }
        result::init()?;
        let device = result::device::get(0)?;
        // SAFETY: calls of the driver with valid arguments.
        unsafe {
            result::ctx::set_current(result::primary_ctx::retain(device)?)?;
            let module = result::module::load_data(image.as_ptr().cast())?;
            let shell = result::malloc_sync(SHELL_BYTES)?;
            let gpu = Self { module, device, shell };
            // The compiler cannot know the depth of calls through tables.
            result::ctx::set_limit(sys::CUlimit::CU_LIMIT_STACK_SIZE, STACK)?;
            let (sheet, columns) = (upload(&[SHEET])?, upload(&[0_u64])?);
            gpu.launch("build", [1, 1], &mut [sheet, shell, columns], Some(SHELL_BYTES as u32))?;
            result::ctx::synchronize()?;
            let mut seen = [0_u64];
            result::memcpy_dtoh_sync(&mut seen, columns)?;
            if seen[0] != COLUMNS as u64 {
                return Err(format!("the device has {} columns, not {COLUMNS}", seen[0]).into());
            }
            Ok(gpu)
        }
    }

    pub fn name(&self) -> Result<String, DriverError> {
        result::device::get_name(self.device)
    }

    unsafe fn launch(
        &self,
        kernel: &str,
        [blocks, threads]: [u32; 2],
        pointers: &mut [sys::CUdeviceptr],
        number: Option<u32>,
    ) -> Result<(), Box<dyn Error>> {
        let mut number = number;
        let mut arguments: Vec<*mut c_void> =
            pointers.iter_mut().map(|p| std::ptr::from_mut(p).cast()).collect();
        if let Some(number) = &mut number {
            arguments.push(std::ptr::from_mut(number).cast());
        }
        unsafe {
            let function = result::module::get_function(self.module, CString::new(kernel)?)?;
            let (grid, block) = ((blocks, 1, 1), (threads, 1, 1));
            result::launch_kernel(function, grid, block, 0, null_mut(), &mut arguments)?;
        }
        Ok(())
    }

    /// Copies a scene to the device.
    pub fn upload(&self, scene: &Scene) -> Result<OnDevice<'_>, Box<dyn Error>> {
        let d = &scene.data;
        let counts = [d.corners.len() / 4, d.x.len()];
        // SAFETY: calls of the driver with valid arguments.
        unsafe {
            let buffers = vec![
                upload(&d.corners)?,
                upload(&d.history)?,
                upload(&d.energies)?,
                upload(&d.forces)?,
                upload(&d.trouble)?,
                upload(&d.x)?,
                upload(&d.v)?,
                upload(&d.w)?,
                upload(&d.inverse)?,
                upload(&d.start)?,
                upload(&d.slots)?,
            ];
            let mesh = Mesh {
                count: counts[0],
                nodes: counts[1],
                corners: buffers[0] as *const _,
                history: buffers[1] as *mut _,
                energies: buffers[2] as *mut _,
                forces: buffers[3] as *mut _,
                trouble: buffers[4] as *const _,
                x: buffers[5] as *mut _,
                v: buffers[6] as *mut _,
                w: buffers[7] as *mut _,
                inverse: buffers[8] as *const _,
                start: buffers[9] as *const _,
                slots: buffers[10] as *const _,
            };
            let (mesh, steps) = (
                upload(&[mesh])?,
                upload(&std::array::from_fn::<_, { STEPS as usize }, _>(|_| Step::new(0.0)))?,
            );
            Ok(OnDevice { gpu: self, host: d.clone(), buffers, mesh, steps, counts, done: 0 })
        }
    }
}

impl OnDevice<'_> {
    fn elements(&mut self, kernel: &str, threads: u32) -> Result<(), Box<dyn Error>> {
        assert!(threads.is_multiple_of(32), "a minimum over warps needs whole warps");
        let blocks = (self.counts[0] as u32).div_ceil(threads);
        let step = self.steps + u64::from(self.done % STEPS) * size_of::<Step>() as u64;
        // SAFETY: the arguments are those of the kernel.
        unsafe {
            self.gpu.launch(kernel, [blocks, threads], &mut [self.gpu.shell, self.mesh, step], None)
        }
    }

    fn nodes(&mut self) -> Result<(), Box<dyn Error>> {
        let grid = [(self.counts[1] as u32).div_ceil(128), 128];
        // SAFETY: the arguments are those of the kernel.
        unsafe { self.gpu.launch("nodes", grid, &mut [self.mesh, self.steps], Some(self.done)) }
    }

    /// Does steps.
    pub fn run(&mut self, kernel: &str, threads: u32, steps: u32) -> Result<(), Box<dyn Error>> {
        for _ in 0..steps {
            self.elements(kernel, threads)?;
            self.nodes()?;
            self.done += 1;
        }
        result::ctx::synchronize()?;
        Ok(())
    }

    /// Times steps: first whole ones, then each kernel in them alone.
    pub fn time(
        &mut self,
        kernel: &str,
        threads: u32,
        steps: u32,
    ) -> Result<Times, Box<dyn Error>> {
        let event = || result::event::create(sys::CUevent_flags::CU_EVENT_DEFAULT);
        let [from, to] = [event()?, event()?];
        // SAFETY: calls of the driver with valid arguments.
        unsafe {
            let mut whole = || -> Result<f64, Box<dyn Error>> {
                result::event::record(from, null_mut())?;
                self.run(kernel, threads, steps)?;
                result::event::record(to, null_mut())?;
                result::event::synchronize(to)?;
                Ok(f64::from(result::event::elapsed(from, to)?) / f64::from(steps))
            };
            let step = whole()?;
            // Only some steps: events between the kernels take time of their own.
            let few = steps.min(20);
            let mut sums = [0.0; 2];
            let middle = event()?;
            for _ in 0..few {
                result::event::record(from, null_mut())?;
                self.elements(kernel, threads)?;
                result::event::record(middle, null_mut())?;
                self.nodes()?;
                result::event::record(to, null_mut())?;
                result::event::synchronize(to)?;
                self.done += 1;
                sums[0] += f64::from(result::event::elapsed(from, middle)?);
                sums[1] += f64::from(result::event::elapsed(middle, to)?);
            }
            let [elements, nodes] = sums.map(|sum| sum / f64::from(few));
            Ok(Times { elements, nodes, step })
        }
    }

    /// Copies the state to the host.
    pub fn download(mut self) -> Result<Columns, DriverError> {
        let b = &self.buffers;
        // SAFETY: the buffers have the lengths of the columns.
        unsafe {
            result::memcpy_dtoh_sync(&mut self.host.history, b[1])?;
            result::memcpy_dtoh_sync(&mut self.host.energies, b[2])?;
            result::memcpy_dtoh_sync(&mut self.host.trouble, b[4])?;
            result::memcpy_dtoh_sync(&mut self.host.x, b[5])?;
            result::memcpy_dtoh_sync(&mut self.host.v, b[6])?;
            result::memcpy_dtoh_sync(&mut self.host.w, b[7])?;
        }
        Ok(self.host.clone())
    }
}

impl Drop for OnDevice<'_> {
    fn drop(&mut self) {
        for &buffer in self.buffers.iter().chain([&self.mesh, &self.steps]) {
            // SAFETY: they were allocated in `upload`. An error here has been reported before.
            let _ = unsafe { result::free_sync(buffer) };
        }
    }
}

/// Copies numbers to new memory of the device.
unsafe fn upload<T>(numbers: &[T]) -> Result<sys::CUdeviceptr, DriverError> {
    unsafe {
        let to = result::malloc_sync(size_of_val(numbers))?;
        result::memcpy_htod_sync(to, numbers)?;
        Ok(to)
    }
}
