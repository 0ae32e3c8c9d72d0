//! The futures of a board on tokio can be spawned as tasks that move between threads.

use stepwright_host::{AsyncBoard, Error, MotionLimits};
use tokio::io::{AsyncReadExt, AsyncWriteExt};

/// A spawned task, on a line that is closed after the first byte.
#[tokio::test]
async fn a_task_of_a_board_is_spawned() {
    let (line, mut end) = tokio::io::duplex(256);
    let task = tokio::spawn(async move {
        let mut board = AsyncBoard::on(line).await?;
        let mut x = board.axis(1)?;
        let moved = x.move_to(2_000, &MotionLimits::default()).await?;
        board.stop().await?;
        Ok::<_, Error>(moved)
    });
    let mut first = [0; 1];
    end.read_exact(&mut first).await.unwrap();
    end.shutdown().await.unwrap();
    drop(end);
    let ended = task.await.unwrap();
    assert!(matches!(ended, Err(Error::Lost { moving: false, .. })), "{ended:?}");
}
