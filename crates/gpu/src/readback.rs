//! Readback: copies parts of buffers to the host, by way of a buffer that both can see.

use std::borrow::Cow;

use wgpu::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder};

use crate::buffers::Part;
use crate::device::Opened;
use hexcast_core::base::error::{Error, Result};

/// The buffer that both can see, reused: a new one costs the driver far more than the copy.
#[derive(Default)]
pub(crate) struct Staging(pub(crate) Option<Buffer>);

/// Parts of buffers that are being copied.
pub(crate) struct Pending<const N: usize> {
    staging: Buffer,
    submission: wgpu::SubmissionIndex,
    mapped: futures_channel::oneshot::Receiver<std::result::Result<(), wgpu::BufferAsyncError>>,
    sizes: [u64; N],
}

impl Staging {
    /// Submits the commands with copies of parts of buffers behind them.
    pub(crate) fn submit<const N: usize>(
        &mut self,
        opened: &Opened,
        mut encoder: CommandEncoder,
        parts: [Part; N],
    ) -> Pending<N> {
        let total: u64 = parts.iter().map(|part| part.bytes[1]).sum();
        let staging = self.take(opened, total);
        let mut at = 0;
        for Part { buffer, bytes: [start, size], .. } in parts {
            encoder.copy_buffer_to_buffer(buffer, start, &staging, at, size);
            at += size;
        }
        let submission = opened.queue.submit([encoder.finish()]);
        let (sender, mapped) = futures_channel::oneshot::channel();
        staging.map_async(wgpu::MapMode::Read, 0..total.max(4), move |result| {
            // the receiver is gone only if the mesh was dropped
            let _ = sender.send(result);
        });
        Pending { staging, submission, mapped, sizes: parts.map(|part| part.bytes[1]) }
    }

    /// Submits the commands, waits for them, and copies parts of buffers behind them, as words.
    pub(crate) async fn read<const N: usize>(
        &mut self,
        opened: &Opened,
        encoder: CommandEncoder,
        parts: [Part<'_>; N],
    ) -> Result<[Vec<u32>; N]> {
        let pending = self.submit(opened, encoder, parts);
        self.words(opened, pending).await
    }

    /// Waits for a submission and copies its parts, as words.
    pub(crate) async fn words<const N: usize>(
        &mut self,
        opened: &Opened,
        pending: Pending<N>,
    ) -> Result<[Vec<u32>; N]> {
        self.parts(opened, pending, |parts| parts.map(bytemuck::pod_collect_to_vec)).await
    }

    /// Waits for a submission and hands out its parts where they lie.
    pub(crate) async fn parts<const N: usize, T>(
        &mut self,
        opened: &Opened,
        pending: Pending<N>,
        take: impl FnOnce([&[u8]; N]) -> T,
    ) -> Result<T> {
        let Pending { staging, submission, mapped, sizes } = pending;
        // what was refused is not waited for: it never ends
        opened.check()?;
        // natively this blocks until this submission is done; in a browser it does nothing and the await waits
        let wait = wgpu::PollType::Wait { submission_index: Some(submission), timeout: None };
        let polled = opened.device.poll(wait);
        let mapped = mapped.await;
        opened.check()?;
        polled.map_err(|error| failed(&error))?;
        mapped.map_err(|error| failed(&error))?.map_err(|error| failed(&error))?;
        let total: u64 = sizes.iter().sum();
        let view = staging.get_mapped_range(0..total.max(4)).map_err(|error| failed(&error))?;
        let mut rest = &view[..];
        let taken = take(sizes.map(|size| {
            let (part, after) = rest.split_at(size as usize);
            rest = after;
            part
        }));
        drop(view);
        staging.unmap();
        self.0 = Some(staging);
        Ok(taken)
    }

    fn take(&mut self, opened: &Opened, size: u64) -> Buffer {
        match self.0.take() {
            Some(staging) if staging.size() >= size => staging,
            _ => opened.device.create_buffer(&BufferDescriptor {
                label: Some("staging"),
                // bands are not all as crowded
                size: (size + size / 4).max(1).next_multiple_of(1 << 12),
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            }),
        }
    }
}

/// The elements of a mapped buffer, where they lie if they are aligned there.
pub(crate) fn elements<T: bytemuck::Pod>(bytes: &[u8]) -> Cow<'_, [T]> {
    bytemuck::try_cast_slice(bytes).map_or_else(|_| bytemuck::pod_collect_to_vec(bytes).into(), Cow::Borrowed)
}

fn failed(error: &dyn std::fmt::Display) -> Error {
    Error::new("device-failed", format!("the GPU's result could not be read: {error}"), "use the CPU backend")
}
